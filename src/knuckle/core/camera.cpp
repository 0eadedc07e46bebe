// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/camera.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/error.h"
#include "knuckle/core/image_size.h"
#include "knuckle/core/limits.h"

namespace knuckle {

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
  if (!std::isfinite(camera.fx) || camera.fx == 0.0)
    fail("camera: fx is {}, expected a number but 0", camera.fx);
  if (!std::isfinite(camera.fy) || camera.fy == 0.0)
    fail("camera: fy is {}, expected a number but 0", camera.fy);
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
