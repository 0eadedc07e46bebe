// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/data/frame_stream.h"
#include "knuckle/stream/camera_stream.h"

namespace knuckle {

/// How long a camera is looked at.
struct CheckLimits {
  int most_frames = 90;       ///< at least 2
  double most_seconds = 5.0;  ///< after the first frame
};

/// What a camera's frames show.
struct CameraCheck {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  bool has_infrared = false;
  std::int64_t frames = 0;
  std::int64_t lost = 0;             ///< as FrameStream::lost_frames
  double rate_hz = 0.0;              ///< frames per second by their times; 0 where fewer than 2 came
  double measured_share = 0.0;       ///< of pixels, mean over frames, [0, 1]
  std::optional<double> nearest_mm;  ///< 1 of 100 measured pixels is nearer
  std::optional<double> median_mm;
  std::optional<double> farthest_mm;  ///< 1 of 100 is farther
  std::optional<double> noise_mm;     ///< standard deviation from frame to frame, as 2 of 3 pixels show it
  bool is_still = false;              ///< all frames are the same to the bit
};

/// Looks at what a camera gives. Throws what the stream throws.
CameraCheck check_camera(FrameStream& stream, const CheckLimits& limits = {});

/// What is wrong, and what to do: sentences for a person; none where all is well.
std::vector<std::string> remarks_on(const CameraCheck& check, const CameraFacts& facts);

}  // namespace knuckle
