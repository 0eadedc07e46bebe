// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/frame_ledger.h"

#include <utility>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

using Lock = std::lock_guard<std::mutex>;

template <class T>
void require_camera_size(const Image<T>& image, const Camera& camera, std::string_view what,
                         std::string_view where) {
  if (image.width() != camera.width || image.height() != camera.height) {
    fail("{}: its {} image is {}x{} pixels, its camera {}x{}", where, what, image.width(), image.height(),
         camera.width, camera.height);
  }
}

bool fit_together(FrameLayout a, FrameLayout b, FrameCameras cameras) {
  if (cameras == FrameCameras::of_one_size) {
    for (Camera* camera : {&a.camera, &b.camera}) camera->fx = camera->fy = camera->cx = camera->cy = 0.0;
  }
  return a == b;
}

FrameLayout checked_layout(const Frame& frame, std::string_view where) {
  require_camera_size(frame.depth_mm, frame.camera, "depth", where);
  if (!frame.infrared.empty()) require_camera_size(frame.infrared, frame.camera, "infrared", where);
  if (!frame.mask.empty()) require_camera_size(frame.mask, frame.camera, "mask", where);
  if (!frame.labels.empty()) require_camera_size(frame.labels, frame.camera, "label", where);
  return {frame.camera, !frame.infrared.empty(), !frame.mask.empty(), !frame.labels.empty(),
          frame.time_s.has_value()};
}

}  // namespace

FrameLedger::FrameLedger(std::string where, const FrameWriterOptions& options, FrameCameras cameras)
    : where_(std::move(where)),
      first_(options.first),
      count_(options.count),
      cameras_(cameras),
      entered_(options.first),
      written_(options.first) {
  if (first_ < 0 || count_ < 0) fail("{}: frames {} and {} more cannot be written", where_, first_, count_);
}

void FrameLedger::enter(std::int64_t index, const Frame& frame) {
  const std::string where = fmt::format("{}: frame {}", where_, index);
  if (index < first_ || (count_ > 0 && index - first_ >= count_))
    fail("{} is out of range: {} from {} on were announced", where, count_, first_);
  const FrameLayout layout = checked_layout(frame, where);
  const Lock lock(mutex_);
  if (!layout_) layout_ = layout;
  if (layout.has_time != layout_->has_time) {
    fail("{} has {} time, the frames before have {}", where, layout.has_time ? "a" : "no",
         layout_->has_time ? "one" : "none");
  }
  if (!fit_together(layout, *layout_, cameras_))
    fail("{} has another camera or other images than the frames before", where);
  if (!entered_.insert(index)) fail("{} comes twice", where);
}

void FrameLedger::note_written(std::int64_t index) {
  const Lock lock(mutex_);
  written_.insert(index);
}

void FrameLedger::restore(const FrameLayout& layout, const std::vector<std::int64_t>& indices) {
  const Lock lock(mutex_);
  layout_ = layout;
  for (const std::int64_t index : indices) {
    entered_.insert(index);
    written_.insert(index);
  }
}

bool FrameLedger::has(std::int64_t index) const {
  const Lock lock(mutex_);
  return written_.contains(index);
}

std::int64_t FrameLedger::size() const {
  const Lock lock(mutex_);
  return written_.size();
}

std::optional<FrameLayout> FrameLedger::layout() const {
  const Lock lock(mutex_);
  return layout_;
}

void FrameLedger::require_complete() const {
  const Lock lock(mutex_);
  if (written_.empty()) fail("{}: no frame was written", where_);
  const std::int64_t written = written_.size();
  const std::int64_t expected = count_ > 0 ? count_ : entered_.size();
  if (written != expected) fail("{}: {} of {} frames were not written", where_, expected - written, expected);
}

}  // namespace knuckle
