// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace knuckle {

/// How a recording stands.
struct RecordingState {
  std::string file = {};     ///< name of the file or folder, without those above it; empty: none is running
  std::int64_t frames = 0;   ///< that are recorded, or wait to be
  std::int64_t dropped = 0;  ///< that came too fast to be written, or do not fit the frames before
  std::string fault = {};    ///< why the last one ended before its time, in a line; empty: it did not
};

}  // namespace knuckle
