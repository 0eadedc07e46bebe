// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/hand/landmark_definition.h"
#include "knuckle/label/label_book.h"
#include "knuckle/label/label_smoothing.h"

namespace knuckle {

/// Which labels a source is given, and how.
struct LabelledSourceOptions {
  LabelState least = LabelState::verified;  ///< hands that are less sure are left out
  std::optional<HandSide> side = {};        ///< nothing: of a frame with both the surer one, else the right
  bool takes_second = false;                ///< of frames with both hands, the other one; no others
  bool keeps_hidden = true;                 ///< otherwise landmarks that are hidden are missing
  int smooth_frames = 0;  ///< `smoothed_labels` over so many frames on both sides; 0: as they are
  std::optional<Convention> convention = {};  ///< of the truth; nothing: as it was labelled
};

/// A source with labels in place of its own truth: one hand per frame, none where the frame is not labelled.
/// Of frames with both hands `Frame::hands` has both, that of the truth first; what hides a landmark nobody
/// has labelled, so it is said to be the hand itself.
/// Landmarks of another convention are found as its definition says (landmarks/NAME.toml), where the program
/// ships one, and by their names otherwise. Where any of the hands that count has a mask, all frames have
/// one, in place of the source's own: the pixels of all hands that count, of both sides where none is asked
/// for. Safe to read from many threads.
class LabelledSource final : public FrameSource {
 public:
  /// Source and book have to live as long. Throws an Error where the source has another number of frames,
  /// or the labels say nothing in the convention.
  LabelledSource(const FrameSource& source, const LabelBook& book, const LabelledSourceOptions& options);

  std::int64_t size() const override { return source_.size(); }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override { return target_; }
  PixelOrigin pixel_origin() const override { return source_.pixel_origin(); }
  /// Frames that have a hand without a mask, although others have one: none of its pixels is said to be hand.
  std::int64_t without_mask_count() const;
  /// Frames of which both hands count.
  std::int64_t two_handed_count() const { return static_cast<std::int64_t>(others_.size()); }
  /// Frames that have a hand.
  std::int64_t labelled_count() const { return static_cast<std::int64_t>(chosen_.size()); }

 private:
  void choose(HandKey hand, const HandHistory& history);
  Image<std::uint8_t> mask_of(std::int64_t index, const Camera& camera) const;
  std::optional<HandTruth> truth_of(std::int64_t index, const Camera& camera) const;
  HandTruth as_truth(const LabelChange& change, const Camera& camera) const;
  HandPose in_target(const HandPose& pose, HandSide side, const Camera& camera) const;
  HandPose as_labelled(const LabelChange& change) const;
  const ImagePoint& place_of(const LabelChange& change, std::size_t landmark) const;

  const FrameSource& source_;
  const LabelBook& book_;
  LabelledSourceOptions options_;
  Convention target_;
  std::optional<LandmarkDefinition> definition_;       ///< where names do not say it
  std::map<std::int64_t, const HandHistory*> chosen_;  ///< by frame: the hand whose pose is the truth
  std::map<std::int64_t, const HandHistory*> others_;  ///< by frame with both hands: the other one
  SmoothedLabels smoothed_;                            ///< empty: labels are as they are
  std::map<std::int64_t, std::vector<std::shared_ptr<const LabelMask>>> masks_;  ///< by frame, of all hands
};

}  // namespace knuckle
