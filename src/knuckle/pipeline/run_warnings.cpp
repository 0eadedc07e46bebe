// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/run_warnings.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>

namespace knuckle {
namespace {

constexpr double kNearestHandMm = 100.0;
constexpr double kFarthestHandMm = 3000.0;
/// A principal point farther from the image's middle than this share of its width or height is unlikely:
/// cameras have a few hundredths, fx in place of cx makes a fifth or more.
constexpr double kLargestOffset = 0.15;
constexpr std::size_t kSampledPixels = 4000;

bool is_off(double principal_px, int size_px) {
  return std::abs(principal_px - 0.5 * (size_px - 1)) > kLargestOffset * size_px;
}

bool is_odd(const Camera& camera) {
  return camera.model == CameraModel::projective &&
         (is_off(camera.cx, camera.width) || is_off(camera.cy, camera.height));
}

/// How far the nearest things are: a twentieth of the measured pixels is nearer. Nothing without
/// measurements.
std::optional<double> near_depth_mm(const Image<float>& depth_mm) {
  const std::size_t step = depth_mm.size() / kSampledPixels + 1;
  std::vector<float> depths;
  for (std::size_t i = 0; i < depth_mm.size(); i += step) {
    if (is_measured(depth_mm.data()[i])) depths.push_back(depth_mm.data()[i]);
  }
  if (depths.empty()) return std::nullopt;
  const auto place = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 20);
  std::ranges::nth_element(depths, place);
  return *place;
}

std::string camera_message(const Camera& camera) {
  const bool is_exchanged = is_off(camera.cx, camera.width) && !is_off(camera.fx, camera.width);
  const std::string likely = is_exchanged ? "fx and cx are probably exchanged"
                                          : "the intrinsics are probably wrong, or of another resolution";
  return fmt::format(
      "the principal point (cx {:.1f}, cy {:.1f}) is far from the middle of the image ({} x {} px; fx "
      "{:.1f}, fy "
      "{:.1f}): {}; check the camera's fx, fy, cx, cy",
      camera.cx, camera.cy, camera.width, camera.height, camera.fx, camera.fy, likely);
}

std::string distance_message(std::int64_t frames, std::int64_t all, std::string_view extreme) {
  return fmt::format(
      "in {} of {} frames hands, or what is nearest, are not between 0.1 and 3 m away ({}): the unit of the "
      "depth is "
      "probably wrong; check the source's depth_unit_mm",
      frames, all, extreme);
}

}  // namespace

void RunWarnings::add(const Frame& frame, const FrameEstimate& estimate) {
  // With a wrong unit nothing has the size of a hand, so none is found: then what is nearest stands for it.
  const std::optional<double> distance_mm = estimate.hands.empty()
                                                ? near_depth_mm(frame.depth_mm)
                                                : std::optional(estimate.hands.front().region.centre.z());
  const std::lock_guard lock(mutex_);
  ++frames_;
  if (!estimate.status.empty()) ++frames_without_sure_hand_;
  add_camera(frame.camera);
  if (distance_mm) add_distance(*distance_mm);
}

void RunWarnings::add_camera(const Camera& camera) {
  if (!is_odd(camera)) return;
  if (odd_cameras_ == 0) odd_camera_ = camera;
  ++odd_cameras_;
}

void RunWarnings::add_distance(double distance_mm) {
  ++frames_with_distance_;
  if (distance_mm < kNearestHandMm) ++near_frames_;
  if (distance_mm > kFarthestHandMm) ++far_frames_;
  nearest_mm_ = std::min(nearest_mm_, distance_mm);
  farthest_mm_ = std::max(farthest_mm_, distance_mm);
}

std::vector<std::string> RunWarnings::messages() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> messages;
  if (2 * near_frames_ > frames_with_distance_) {
    messages.push_back(distance_message(near_frames_, frames_with_distance_,
                                        fmt::format("the nearest {:.2f} m", nearest_mm_ / 1000.0)));
  }
  if (2 * far_frames_ > frames_with_distance_) {
    messages.push_back(distance_message(far_frames_, frames_with_distance_,
                                        fmt::format("the farthest {:.2f} m", farthest_mm_ / 1000.0)));
  }
  if (2 * odd_cameras_ > frames_) messages.push_back(camera_message(odd_camera_));
  if (2 * frames_without_sure_hand_ > frames_) {
    messages.push_back(fmt::format(
        "no sure hand in {} of {} frames; usual causes: wrong intrinsics or depth unit, a hand that is too "
        "far away, a "
        "left hand (set side = \"left\" under [hand]), or other things that are nearer than the hand",
        frames_without_sure_hand_, frames_));
  }
  return messages;
}

}  // namespace knuckle
