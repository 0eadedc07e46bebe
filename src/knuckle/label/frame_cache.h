// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include "knuckle/data/frame_source.h"

namespace knuckle {

/// The frames of a source that were read last, so that one that is looked at for a while is read once. Safe
/// to use from many threads.
class FrameCache {
 public:
  /// Keeps `most` frames; the source has to live as long.
  FrameCache(const FrameSource& source, std::size_t most) : source_(source), most_(most) {}

  /// Throws an Error where there is no such frame or it cannot be read.
  std::shared_ptr<const Frame> read(std::int64_t index);

 private:
  const FrameSource& source_;
  std::size_t most_;
  std::mutex mutex_;
  std::deque<std::pair<std::int64_t, std::shared_ptr<const Frame>>> frames_;
};

}  // namespace knuckle
