// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/camera.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/error.h"
#include "knuckle/core/image_size.h"
#include "knuckle/core/limits.h"

namespace knuckle {
namespace {

/// Beyond these bounds points that a pixel stands for are no finite numbers.
void check_focal_length(double value, const char* name) {
  constexpr double kLeast = 1e-6;
  constexpr double kMost = 1e9;
  if (!(std::abs(value) >= kLeast && std::abs(value) <= kMost))
    fail("camera: {} is {}, expected a size from {:g} to {:g}", name, value, kLeast, kMost);
}

}  // namespace

bool Camera::is_distorted() const {
  return std::ranges::any_of(distortion, [](double coefficient) { return coefficient != 0.0; });
}

void check(const Camera& camera) {
  if (camera.width < 1) fail("camera: width is {}, expected at least 1", camera.width);
  if (camera.height < 1) fail("camera: height is {}, expected at least 1", camera.height);
  if (camera.width > limits::kImageSide || camera.height > limits::kImageSide) {
    fail("camera: {} x {} pixels, expected at most {} a side", camera.width, camera.height,
         limits::kImageSide);
  }
  require_image_size({camera.width, camera.height}, "camera");
  check_focal_length(camera.fx, "fx");
  check_focal_length(camera.fy, "fy");
  if (!std::isfinite(camera.cx)) fail("camera: cx is {}, expected a number", camera.cx);
  if (!std::isfinite(camera.cy)) fail("camera: cy is {}, expected a number", camera.cy);
  for (const double coefficient : camera.distortion) {
    if (!std::isfinite(coefficient)) fail("camera: distortion holds {}, expected numbers", coefficient);
  }
  if (camera.model == CameraModel::orthographic && camera.is_distorted()) {
    fail("camera: distortion is given for an orthographic camera, which has none");
  }
}

Camera with_pixel_origin(Camera camera, PixelOrigin from, PixelOrigin to) {
  if (from == to) return camera;
  const double shift = to == PixelOrigin::centre ? -0.5 : 0.5;
  camera.cx += shift;
  camera.cy += shift;
  return camera;
}

Camera mirrored(Camera camera) {
  constexpr int kTangentialP2 = 3;
  camera.cx = camera.width - 1 - camera.cx;
  camera.distortion[kTangentialP2] = -camera.distortion[kTangentialP2];
  return camera;
}

}  // namespace knuckle
