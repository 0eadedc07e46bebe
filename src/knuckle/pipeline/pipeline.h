// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/estimate/estimator.h"
#include "knuckle/hand/hand_angles.h"
#include "knuckle/hand/landmark_definition.h"
#include "knuckle/pipeline/hand_finder.h"
#include "knuckle/pipeline/tracker_options.h"
#include "knuckle/refine/refiner.h"

namespace knuckle {

/// Wall time of each stage [ms].
struct StageTimes {
  double segment_ms = 0.0;
  double patch_ms = 0.0;
  double estimate_ms = 0.0;
  double refine_ms = 0.0;

  double total_ms() const { return segment_ms + patch_ms + estimate_ms + refine_ms; }
};

/// One hand of a frame: where it is, and its pose in the frame's image coordinates.
struct HandEstimate {
  HandRegion
      region;  ///< what was looked at last: the segmented hand, or what lies in the cube of a later look
  HandPose pose;
  /// How sure it is that this is a hand, [0, 1]: the mean confidence of its joints (1 where the method gives
  /// none), times how plausible refiners find it, times the root of how likely segmentation finds a hand
  /// there.
  double score = 1.0;
  HandSide side = HandSide::right;  ///< as which it was looked at (`HandOptions::side`)
  /// How likely the hand is of that side, as the estimator and the `side_model` see it, [0, 1]; nothing: they
  /// cannot tell.
  std::optional<double> side_confidence = {};
  int id = 0;  ///< of a hand that is followed from frame to frame, from 1 on; 0: it is not
  std::optional<HandAngles> angles = {};  ///< of the skeleton that was fitted to it
  std::string skeleton = {};              ///< its name; empty where none was
};

/// The status of a frame in which a start was given and the pose found there is not sure.
inline constexpr std::string_view kUnsure = "unsure";

/// What a pipeline sees in a frame. No hand is an answer, not an error.
struct FrameEstimate {
  std::vector<HandEstimate> hands;  ///< surest first
  /// Empty where a sure hand was found; why there is none, in words; or `kUnsure`.
  std::string status;
  std::vector<HandRegion> known;  ///< where hands are that the search knew: their poses were not estimated
  StageTimes times;
};

/// Where a frame is searched for hands, and for how many.
struct Search {
  std::optional<Point3> start =
      std::nullopt;  ///< where to look for the hand, in camera coordinates [mm]; it is trusted
  std::optional<bool> elsewhere = std::nullopt;  ///< in other places too? unset: only where no start is given
  int max_hands = 1;                             ///< [1, 16]
  /// Which hand it is known to be; unset: as is seen. Only where the pipeline's `side` is auto.
  std::optional<HandSide> side = std::nullopt;
  /// Middles of hands that are known already, in camera coordinates [mm]. A place that is found within 80 mm
  /// of one counts as a hand, and is not looked at.
  std::vector<Point3> known = {};
  bool calibrate =
      true;  ///< false: joints' confidences are what the estimator says, for one that weighs by them
};

/// What a pipeline is put together from: stages that come with Knuckle, or your own (docs/extending.md).
struct PipelineParts {
  HandFinder finder;
  std::unique_ptr<Estimator> estimator;
  std::vector<std::unique_ptr<Refiner>> refiners = {};  ///< in the order in which they work; none is fine
  std::optional<TrackerOptions> tracker = {};           ///< nothing: frames are seen by themselves
};

/// The paper's framework (its Figure 1): segment, crop, estimate, refine.
class Pipeline {
 public:
  /// The pipeline that a file describes. An estimator of one's own, where one is given, takes the place of
  /// the tables `[estimator]` and `[patch]`, of which nothing is read then. Throws an Error that names file,
  /// line and key where the file, or a model that it names, is wrong.
  static Pipeline load(const std::filesystem::path& path, std::unique_ptr<Estimator> own = nullptr);
  /// The pipeline that the text of such a file describes; relative paths in it start from `folder`. Messages
  /// call it "pipeline" where they would name a file.
  static Pipeline from_toml(std::string_view toml, const std::filesystem::path& folder,
                            std::unique_ptr<Estimator> own = nullptr);

  /// A pipeline of these parts; patches are made as the estimator asks for. Throws an Error where a part is
  /// missing (null).
  explicit Pipeline(PipelineParts parts);

  /// From now on poses have the landmarks of that definition in place of the model's: what comes out of the
  /// last stage is moved to where a data set's authors label. Throws an Error where the model's convention
  /// lacks one of the 22 landmarks, or the pipeline has a tracker, which needs them as they are. Not to be
  /// called while other threads use the pipeline.
  void use_landmarks(const LandmarkDefinition& definition);

  /// The convention of all poses: that of `use_landmarks`, else the model's.
  Convention convention() const { return landmarks_ ? landmarks_->convention : estimator_->convention(); }

  const HandOptions& hand() const { return finder_.hand(); }

  /// Whether and how hands are to be followed: the table `[tracker]`. The pipeline itself sees single frames;
  /// who runs it over a sequence looks here (`track_each`).
  const std::optional<TrackerOptions>& tracker() const { return tracker_; }

  /// The pipeline file with all defaults filled in; empty where there was no file.
  const std::string& resolved_options() const { return resolved_options_; }

  /// Finds the hands of a frame and their poses, from no start and `HandOptions::max_hands` at most. Where a
  /// pose is not sure, other places are tried (`HandOptions::candidates`): the nearest thing may be an elbow.
  /// What is not sure is not found. Safe to call from many threads.
  FrameEstimate estimate(const Frame& frame) const;
  /// The same, searched as `search` says. A hand at a given start is returned whatever its score. Throws an
  /// Error where the start is not finite or the number of hands is out of range.
  FrameEstimate estimate(const Frame& frame, const Search& search) const;

 private:
  static Pipeline from_table(const OptionTable& document, std::unique_ptr<Estimator> own);
  FrameEstimate estimate_left(const Frame& frame, const Search& search) const;
  FrameEstimate estimate_right(const Frame& frame, const Search& search) const;
  Segmentation found_in(const Frame& frame, const std::optional<Point3>& start, const Search& search,
                        int places, StageTimes& times) const;
  bool is_sure(double score) const;
  /// How a place is looked at.
  struct Look {
    std::optional<HandSide> side = {};  ///< where it is known
    bool may_give_up = false;           ///< what will not be sure need not be looked at to the end
  };
  /// A place at first sight, as a hand of one side.
  struct Sight {
    HandPatch patch;
    PatchPose pose;
    HandRegion region;
    double score = 0.0;
    bool side_is_clear = false;                ///< arm and body tell it, and the hand does not contradict
    std::unique_ptr<const Frame> mirror = {};  ///< the mirrored frame, in which a left hand is looked at

    /// How likely the hand is of that side, as the estimator and the `side_model` see it; nothing: neither
    /// can tell.
    std::optional<double> likelihood_of_side() const;
    /// Whether it need not be looked at as a hand of the other side.
    bool is_sure_of_side() const;
    /// How much speaks for that side, in log odds: a surer pose, too.
    double odds_of_side() const;
  };
  void add_hands(const Frame& frame, std::vector<HandRegion> regions, const Look& look,
                 FrameEstimate& result) const;
  void look_at_start(const Frame& frame, const Search& search, HandEstimate& hand, StageTimes& times) const;
  void look_elsewhere(const Frame& frame, const Search& search, FrameEstimate& result) const;
  std::optional<HandEstimate> hand_in(const Frame& frame, HandRegion region, const Look& look,
                                      StageTimes& times) const;
  std::optional<Sight> sight_of(const Frame& frame, HandRegion region, HandSide side, const Look& look,
                                StageTimes& times) const;
  std::optional<Sight> sight_of_right(const Frame& frame, HandRegion region, const Look& look,
                                      StageTimes& times) const;
  HandEstimate completed(const Frame& frame, Sight sight, const Look& look, StageTimes& times) const;
  HandEstimate completed_right(const Frame& frame, Sight& sight, const Look& look, StageTimes& times) const;
  HandRegion region_looked_at(const Frame& frame, const ImagePoint& centre, const HandRegion& before) const;
  double refine(const Frame& frame, const HandRegion& region, HandPose& pose, HandEstimate& hand) const;
  double score_of(const PatchPose& pose, const HandRegion& region) const;

  std::string resolved_options_;
  HandFinder finder_;
  std::unique_ptr<Estimator> estimator_;
  std::vector<std::unique_ptr<Refiner>> refiners_;
  std::optional<LandmarkDefinition> landmarks_;
  std::optional<TrackerOptions> tracker_;
};

}  // namespace knuckle
