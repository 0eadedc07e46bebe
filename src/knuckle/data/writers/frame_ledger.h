// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/data/writers/frame_writer.h"
#include "knuckle/data/writers/index_set.h"

namespace knuckle {

/// What all frames of a set have in common.
struct FrameLayout {
  Camera camera;
  bool has_infrared = false;
  bool has_mask = false;
  bool has_labels = false;
  bool has_time = false;

  bool operator==(const FrameLayout&) const = default;
};

/// What the cameras of a set's frames must have in common.
enum class FrameCameras {
  all_alike,
  of_one_size,  ///< and one model and distortion; focal length and principal point may differ
};

/// Keeps account of the frames that a writer is handed: that they fit together, that none comes twice, that
/// none is missing in the end. Safe to use from many threads.
class FrameLedger {
 public:
  /// `where` starts all messages.
  FrameLedger(std::string where, const FrameWriterOptions& options,
              FrameCameras cameras = FrameCameras::all_alike);

  /// Enters a frame before it is written; the first one sets the layout. Throws an Error where its index is
  /// out of range or was entered before, its images differ in size, or its layout differs from the first
  /// one's.
  void enter(std::int64_t index, const Frame& frame);
  /// Notes that an entered frame is written.
  void note_written(std::int64_t index);
  /// Enters frames that an earlier run has written.
  void restore(const FrameLayout& layout, const std::vector<std::int64_t>& indices);

  bool has(std::int64_t index) const;  ///< whether it is written
  std::int64_t size() const;           ///< frames that are written
  std::optional<FrameLayout> layout() const;
  /// Throws an Error where no frame was written, fewer than were announced, or fewer than came.
  void require_complete() const;

 private:
  std::string where_;
  std::int64_t first_;
  std::int64_t count_;
  FrameCameras cameras_;
  mutable std::mutex mutex_;
  std::optional<FrameLayout> layout_;
  IndexSet entered_;
  IndexSet written_;
};

}  // namespace knuckle
