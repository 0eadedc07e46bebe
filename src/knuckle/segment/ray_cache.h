// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "knuckle/camera/projection.h"
#include "knuckle/segment/camera_cache.h"

namespace knuckle {

/// Keeps the ray tables of the last cameras asked for (and those of their thinned images): undistorting all
/// pixels costs more than segmenting a frame. Safe to call from many threads.
class RayCache {
 public:
  /// Throws an Error where the camera's values are impossible.
  std::shared_ptr<const RayTable> rays_of(const Camera& camera) { return tables_.of(camera); }

 private:
  CameraCache<RayTable> tables_{
      [](const Camera& camera) { return std::make_shared<const RayTable>(camera); }};
};

}  // namespace knuckle
