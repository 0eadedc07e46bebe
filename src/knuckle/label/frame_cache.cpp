// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/frame_cache.h"

#include <algorithm>

#include "knuckle/core/error.h"

namespace knuckle {

std::shared_ptr<const Frame> FrameCache::read(std::int64_t index) {
  if (index < 0 || index >= source_.size())
    fail("there is no frame {}, only 0 to {}", index, source_.size() - 1);
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(frames_, index, [](const auto& entry) { return entry.first; });
    if (found != frames_.end()) return found->second;
  }
  auto frame = std::make_shared<const Frame>(source_.read(index));  // without the lock: others go on
  const std::lock_guard lock(mutex_);
  frames_.emplace_back(index, frame);
  if (frames_.size() > most_) frames_.pop_front();
  return frame;
}

}  // namespace knuckle
