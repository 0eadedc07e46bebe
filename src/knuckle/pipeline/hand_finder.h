// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "knuckle/core/frame.h"
#include "knuckle/core/options.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

class SideNetwork;

/// The `[hand]` table of a pipeline file.
struct HandOptions {
  /// right | left | auto: that which segmentation tells of each hand, and right where it does not
  std::string side = "right";
  int max_hands = 1;  ///< Hands of a frame at most, [1, 16]
  /// Places of a frame that are tried where a pose is not sure, [1, 16]; no more than `max_hands`: none.
  int candidates = 1;
  /// A pose whose joints have less confidence on average is not sure, [0, 1]; a pipeline file that does not
  /// say it has the estimator's (`Estimator::sure_confidence`).
  double sure_confidence = 0.0;
  /// How much counts what the estimator says of whether it is a hand at all: its exponent in the hand's
  /// score, [0, 1]; 0: nothing.
  double hand_weight = 1.0;
  /// Where the score is lower, the estimator is asked for its last word on whether it is a hand
  /// (`Estimator::judged`), [0, 1]; 0: never.
  double judged_below = 0.0;
  /// The confidences of the joints that come out are calibrated (`calibrated_confidence`) with these, [-10,
  /// 10] and [0.01, 10]; scores and all thresholds are of what the estimator says itself.
  double confidence_offset = 0.0;
  double confidence_slope = 1.0;

  void visit(OptionVisitor& visitor);
  bool is_left() const { return side == "left"; }
  bool is_auto() const { return side == "auto"; }
};

/// Finds the hands of a frame: the first stage of a pipeline, `[hand]` and `[segmentation]` of its file.
class HandFinder {
 public:
  /// A segmenter of your own, and who tells the sides of hands where `side` is auto. Throws an Error where
  /// the segmenter is missing (null) or an option is out of range.
  explicit HandFinder(std::unique_ptr<Segmenter> segmenter, const HandOptions& hand = {},
                      std::shared_ptr<const SideNetwork> sides = nullptr);
  /// Reads the two tables of a pipeline's document; options of `[hand]` that it does not have are those of
  /// `defaults`. The caller finishes the document.
  explicit HandFinder(const OptionTable& document, const HandOptions& defaults = {});
  /// Reads a pipeline file for these two alone. Throws an Error that names file, line and key where they are
  /// wrong.
  static HandFinder load(const std::filesystem::path& path);

  const HandOptions& hand() const { return hand_; }
  /// The tables of the file that were read, with all defaults filled in; empty where there was no file.
  const std::string& resolved_options() const { return resolved_options_; }

  /// Regions in the frame's own image, `HandOptions::max_hands` at most, also for a left hand (which the
  /// segmenter sees in a mirror). `start` is in camera coordinates.
  Segmentation find(const Frame& frame, const std::optional<Point3>& start) const;
  /// The same for a frame that already shows a right hand; sides are not told.
  Segmentation find_right(const Frame& frame, const std::optional<Point3>& start) const;
  /// The same with `max_hands` regions at most, [1, 16].
  Segmentation find_right(const Frame& frame, const std::optional<Point3>& start, int max_hands) const;
  /// Tells the sides of a frame's hands where `side` is auto and there is who tells them: `right_hand` and
  /// `side` of each.
  void tell_sides(const Frame& frame, std::vector<HandRegion>& hands) const;

 private:
  HandOptions hand_;
  std::string resolved_options_;
  std::unique_ptr<Segmenter> segmenter_;
  std::shared_ptr<const SideNetwork> sides_;  ///< null: nobody is asked
};

/// The frame as it shows a right hand: in a mirror where it shows a left one. Where the source does not say
/// which it is, `options` does.
Frame as_right_hand(Frame frame, const HandOptions& options);
/// A point in the coordinates of the mirrored camera.
std::optional<Point3> mirrored(const std::optional<Point3>& point);

/// Where segmentation starts when it is told the truth, as in the paper's evaluation of pose estimation: the
/// true palm, or the mean of the known joints of the wrist and the bases of the digits where the palm is not
/// labelled, or of all joints. Nothing where the frame has no truth.
std::optional<Point3> true_start(const Frame& frame);

}  // namespace knuckle
