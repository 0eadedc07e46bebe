// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/ray_cache.h"

namespace knuckle {

std::shared_ptr<const RayTable> RayCache::rays_of(const Camera& camera) {
  const std::lock_guard lock(mutex_);
  if (!last_ || !(last_->camera() == camera)) {
    check(camera);
    last_ = std::make_shared<const RayTable>(camera);
  }
  return last_;
}

}  // namespace knuckle
