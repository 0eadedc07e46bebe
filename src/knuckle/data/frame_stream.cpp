// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/frame_stream.h"

#include <utility>

#include "knuckle/core/error.h"

namespace knuckle {

SourceStream::SourceStream(const FrameSource& source, std::int64_t first, std::optional<std::int64_t> end)
    : source_(source), position_(first), end_(end.value_or(source.size())) {
  if (first < 0 || first > end_ || end_ > source_.size())
    fail("frames [{}, {}) are out of range: the source has {}", first, end_, source_.size());
}

SourceStream::SourceStream(std::unique_ptr<const FrameSource> source, std::int64_t first,
                           std::optional<std::int64_t> end)
    : SourceStream(*source, first, end) {
  owned_ = std::move(source);
}

std::optional<Frame> SourceStream::next() {
  if (position_ == end_) return std::nullopt;
  return source_.read(position_++);  // counted before it is read: a faulty frame is passed over
}

}  // namespace knuckle
