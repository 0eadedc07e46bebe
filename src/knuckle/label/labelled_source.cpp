// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/labelled_source.h"

#include <algorithm>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/data/defined_pose.h"

namespace knuckle {
namespace {

bool has_labels(const HandHistory& history) {
  return history.newest().mask != nullptr ||
         std::ranges::any_of(history.newest().landmarks,
                             [](const LandmarkLabel& label) { return !label.at.is_missing(); });
}

}  // namespace

LabelledSource::LabelledSource(const FrameSource& source, const LabelBook& book,
                               const LabelledSourceOptions& options)
    : source_(source),
      book_(book),
      options_(options),
      target_(options.convention.value_or(book.head().convention)) {
  const LabelHead& head = book.head();
  if (source.size() != head.frames)
    fail("the labels are of {} with {} frames, the source has {}", head.source, head.frames, source.size());
  if (!(target_ == head.convention)) {
    definition_ = definition_of_own_landmarks(target_);
    const bool is_empty = map_convention(head.convention, target_).shared.empty();
    if (definition_) {
      require_all_landmarks(head.convention, "the labels");
    } else if (is_empty) {
      fail("labels in {} say nothing of the landmarks of {}", head.convention.name, target_.name);
    }
  }
  for (const auto& [hand, history] : book.hands()) {
    if (options.side && *options.side != hand.side) continue;
    if (has_labels(history) && history.state() >= options.least) choose(hand, history);
  }
  if (options.smooth_frames != 0)
    smoothed_ = smoothed_labels(source, book, options.least, options.smooth_frames);
}

/// The right hand comes first.
void LabelledSource::choose(HandKey hand, const HandHistory& history) {
  if (history.newest().mask) masks_[hand.frame].push_back(history.newest().mask);
  if (options_.takes_second) {
    const HandHistory* const left = book_.find({hand.frame, HandSide::left});
    if (hand.side == HandSide::right) {
      const bool has_both = left != nullptr && has_labels(*left) && left->state() >= options_.least;
      if (has_both) chosen_[hand.frame] = left->state() > history.state() ? &history : left;
    }
    return;
  }
  const HandHistory*& chosen = chosen_[hand.frame];
  if (chosen == nullptr) {
    chosen = &history;
    return;
  }
  const HandHistory* other = &history;
  if (chosen->state() < other->state()) std::swap(chosen, other);
  if (has_landmarks(other->newest())) others_[hand.frame] = other;
}

std::int64_t LabelledSource::without_mask_count() const {
  if (masks_.empty()) return 0;
  return std::ranges::count_if(chosen_, [this](const auto& one) { return !masks_.contains(one.first); });
}

Image<std::uint8_t> LabelledSource::mask_of(std::int64_t index, const Camera& camera) const {
  Image<std::uint8_t> pixels(camera.width, camera.height);
  const auto found = masks_.find(index);
  if (found == masks_.end()) return pixels;
  for (const auto& mask : found->second) {
    if (mask->width != camera.width || mask->height != camera.height) {
      fail("{}: frame {}: the mask of its labels is of {}x{} pixels, its image of {}x{}", book_.head().source,
           index, mask->width, mask->height, camera.width, camera.height);
    }
    const Image<std::uint8_t> one = pixels_of(*mask);
    std::ranges::transform(one.pixels(), pixels.pixels(), pixels.data(),
                           [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); });
  }
  return pixels;
}

HandPose LabelledSource::as_labelled(const LabelChange& change) const {
  HandPose pose = HandPose::missing(book_.head().convention);
  for (std::size_t i = 0; i < pose.joints.size(); ++i) {
    const LandmarkLabel& label = change.landmarks[i];
    if (label.is_visible || options_.keeps_hidden) pose.joints[i] = place_of(change, i);
  }
  return pose;
}

const ImagePoint& LabelledSource::place_of(const LabelChange& change, std::size_t landmark) const {
  const auto smoothed = smoothed_.find({change.frame, change.side});
  return smoothed == smoothed_.end() ? change.landmarks[landmark].at : smoothed->second[landmark];
}

HandPose LabelledSource::in_target(const HandPose& pose, HandSide side, const Camera& camera) const {
  if (definition_) return defined_pose(*definition_, pose, Projection(camera), side);
  return target_ == pose.convention ? pose : converted(pose, target_);
}

HandTruth LabelledSource::as_truth(const LabelChange& change, const Camera& camera) const {
  HandTruth truth{
      .side = change.side,
      .pose = in_target(as_labelled(change), change.side, camera),
      .occluders = std::vector<Occluder>(target_.landmarks.size(), Occluder::none),
  };
  const std::vector<int> places = map_convention(book_.head().convention, target_).source_index;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool is_hidden =
        places[i] >= 0 && !change.landmarks[static_cast<std::size_t>(places[i])].is_visible;
    if (is_hidden) truth.occluders[i] = Occluder::own_hand;
  }
  return truth;
}

std::optional<HandTruth> LabelledSource::truth_of(std::int64_t index, const Camera& camera) const {
  const auto chosen = chosen_.find(index);
  if (chosen == chosen_.end()) return std::nullopt;
  return as_truth(chosen->second->newest(), camera);
}

Frame LabelledSource::read(std::int64_t index) const {
  Frame frame = source_.read(index);
  frame.truth.reset();
  frame.side.reset();
  frame.hands.clear();
  if (auto truth = truth_of(index, frame.camera)) {
    frame.truth = truth->pose;
    frame.side = truth->side;
    if (const auto other = others_.find(index); other != others_.end())
      frame.hands = {std::move(*truth), as_truth(other->second->newest(), frame.camera)};
  }
  if (!masks_.empty()) {
    frame.mask = mask_of(index, frame.camera);
    frame.labels = {};  // they tell of another truth
  }
  return frame;
}

FrameLabel LabelledSource::read_label(std::int64_t index) const {
  FrameLabel label = source_.read_label(index);
  label.truth.reset();
  label.side.reset();
  if (auto truth = truth_of(index, label.camera)) {
    label.truth = std::move(truth->pose);
    label.side = truth->side;
  }
  return label;
}

}  // namespace knuckle
