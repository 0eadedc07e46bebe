// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "knuckle/core/camera.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/shard.h"

namespace knuckle {

/// Writes frames as a data set that the reader of the same name opens.
///
/// All frames share one camera (h5: its size, model and distortion), and all or none have infrared, a mask
/// and a time. A file appears under its name only when whole; the set is whole after `finish`, and no reader
/// takes it for one before.
class FrameWriter {
 public:
  virtual ~FrameWriter() = default;

  /// Writes frame `index`. Safe to call from many threads, in any order, once an index. Throws an Error that
  /// names the file where it cannot be written, or where the frame does not fit the format or the frames
  /// before.
  virtual void write(std::int64_t index, const Frame& frame) = 0;
  /// Whether an earlier run that was interrupted has already written frame `index`.
  virtual bool has(std::int64_t /*index*/) const { return false; }
  /// Ends the set. Throws an Error where frames are missing. Without it the set stays unfinished.
  virtual void finish() = 0;
};

/// Which frames a writer is given, and how it stores them.
struct FrameWriterOptions {
  std::int64_t first = 0;  ///< index of the first frame, >= 0
  std::int64_t count = 0;  ///< number of frames, >= 0; 0 = as many as come
  double depth_unit_mm =
      0.1;  ///< millimetres a count of depth, (0, 1000]; folder and h5: 0.1 reaches to 6.5 m
  PixelOrigin pixel_origin = PixelOrigin::centre;  ///< of the files of folder; h5 has centre, icg corner
  std::string manifest;                            ///< how the frames were made, kept as text; h5 only
  std::string generator;  ///< the program that makes them, where their bytes hang on its version; h5 only
  std::optional<IndexRange> part_of = {};  ///< of which whole set these frames are a part; h5 only
};

/// folder, h5, icg.
std::span<const std::string_view> frame_writer_formats();

/// A writer into the new folder or file `path`. `h5` goes on where an interrupted run with the same options
/// stopped. Throws an Error that lists the formats where `format` is none, and where `path` already holds a
/// set or cannot be written.
std::unique_ptr<FrameWriter> create_frame_writer(std::string_view format, const std::filesystem::path& path,
                                                 const FrameWriterOptions& options);

}  // namespace knuckle
