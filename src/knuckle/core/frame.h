// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// True where a pixel of a depth image holds a measurement: a finite depth above 0 (so not 0, NaN or
/// infinity).
inline bool is_measured(float depth_mm) {
  return depth_mm > 0.0f && depth_mm <= std::numeric_limits<float>::max();
}

/// Which hand of a person.
enum class HandSide : std::uint8_t { right, left };

/// One depth image with all that is known about it.
struct Frame {
  std::string name;               ///< unique in its source, for messages and pictures; no extension
  Camera camera;                  ///< has the size of the depth image
  Image<float> depth_mm;          ///< distance along z [mm]; 0 = no measurement
  Image<std::uint16_t> infrared;  ///< amplitude in the sensor's own unit; empty where the source has none
  Image<std::uint8_t> mask;       ///< truth: 1 where a pixel is hand, else 0; empty where the source has none
  std::optional<HandPose> truth;  ///< joints in pixel-centre coordinates; joints may be missing
  std::optional<HandSide> side;   ///< truth: which hand it is; nothing where the source does not know
  std::optional<double> time_s;   ///< when it was taken [s], any zero; never goes back within a sequence
  int sequence = 0;               ///< which of the source's sequences it belongs to, >= 0
};

/// The frame in a mirror: images, camera and truth. A left hand becomes a right one,
/// and says so.
Frame mirrored(const Frame& frame);

}  // namespace knuckle
