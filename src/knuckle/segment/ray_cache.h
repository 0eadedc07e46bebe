// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "knuckle/camera/projection.h"

namespace knuckle {

/// Keeps the ray tables of the last cameras asked for: the frames of a recording share one (and those of its
/// thinned images), and undistorting all its pixels costs more than segmenting a frame. Safe to call from
/// many threads; a table lives as long as its users.
class RayCache {
 public:
  /// Throws an Error where the camera's values are impossible.
  std::shared_ptr<const RayTable> rays_of(const Camera& camera);

 private:
  std::mutex mutex_;
  std::vector<std::shared_ptr<const RayTable>> last_;  // the latest first
};

}  // namespace knuckle
