// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/ray_cache.h"

#include <algorithm>
#include <cstddef>

namespace knuckle {
namespace {

constexpr std::size_t kKept = 4;

}  // namespace

std::shared_ptr<const RayTable> RayCache::rays_of(const Camera& camera) {
  const std::lock_guard lock(mutex_);
  const auto known = std::ranges::find(last_, camera, [](const auto& table) { return table->camera(); });
  if (known != last_.end()) {
    std::rotate(last_.begin(), known, known + 1);
    return last_.front();
  }
  check(camera);
  last_.insert(last_.begin(), std::make_shared<const RayTable>(camera));
  if (last_.size() > kKept) last_.pop_back();
  return last_.front();
}

}  // namespace knuckle
