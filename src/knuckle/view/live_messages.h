// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/data/writers/recording_state.h"

namespace knuckle {

/// One frame of a live stream with what was found in it.
struct LiveUpdate {
  std::shared_ptr<const Frame> frame;  ///< never null
  FrameRecord record;
  RecordingState recording = {};
  std::int64_t arrived = 0;      ///< frames until then
  std::int64_t passed_over = 0;  ///< those of them for which there was no time
};

/// What does not change while a stream runs.
struct LiveInfo {
  std::string version;      ///< of the program
  std::string source;       ///< as the user named it
  std::string pipeline;     ///< its file
  Convention convention;    ///< of all landmarks
  bool can_record = false;  ///< whether recordings may be begun and ended
};

/// The answer to /api/info: a JSON object. `newest` is the last frame that was looked at, null before the
/// first: then `camera` is null.
std::string info_message(const LiveInfo& info, const RecordingState& recording, const LiveUpdate* newest);

/// A message of /api/frames: the length of a JSON header as uint32 LE; the header, filled up with blanks so
/// that the depth after it begins at a multiple of 4 bytes; the depth as uint16 LE in the header's
/// `depth_unit_mm`, row by row, 0 = no measurement; then, where the header's `infrared` is true, the infrared
/// image, also uint16 LE.
std::vector<std::uint8_t> frame_message(const LiveUpdate& update);

}  // namespace knuckle
