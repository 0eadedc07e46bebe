// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "knuckle/core/error.h"
#include "knuckle/core/frame.h"
#include "knuckle/data/frame_source.h"

namespace knuckle {

/// A camera is gone: it was unplugged, or sends nothing any more. Its stream has ended.
class DeviceLost : public Error {
 public:
  using Error::Error;
};

/// Frames as they come, one after another, for one reader: a camera, a recording, or a source played.
class FrameStream {
 public:
  virtual ~FrameStream() = default;

  /// The next frame; blocks until it is there. Nothing: the stream has ended, and stays so.
  ///
  /// Throws an Error that names the file or device where the next frame cannot be read. Whoever can do
  /// without that frame calls again for the one after it; a device that was lost has ended then, which
  /// DeviceLost says.
  virtual std::optional<Frame> next() = 0;
  /// Frames that a camera took but that never came: lost on the way, for lack of time or of whole data.
  virtual std::int64_t lost_frames() const { return 0; }
};

/// A source played in order, as fast as it is read.
class SourceStream final : public FrameStream {
 public:
  /// Frames [first, end) of `source`, which must outlive the stream; `end` is at most the source's size,
  /// which is also what it is where it is not given. Throws an Error where the range is not in the source.
  explicit SourceStream(const FrameSource& source, std::int64_t first = 0,
                        std::optional<std::int64_t> end = std::nullopt);
  /// The same of a source that the stream owns.
  explicit SourceStream(std::unique_ptr<const FrameSource> source, std::int64_t first = 0,
                        std::optional<std::int64_t> end = std::nullopt);

  std::optional<Frame> next() override;

 private:
  std::unique_ptr<const FrameSource> owned_;  ///< null where the source is someone else's
  const FrameSource& source_;
  std::int64_t position_;
  std::int64_t end_;
};

}  // namespace knuckle
