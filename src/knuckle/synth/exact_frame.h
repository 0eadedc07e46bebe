// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/synth/sensor/sensor.h"

namespace knuckle {

/// What a camera would see of a scene without any fault, and the truth about it. Labels and hands stay empty
/// where a manifest asks for no scene.
struct ExactFrame {
  SeenSurfaces surfaces;
  Image<std::uint8_t> mask;
  HandPose truth;
  Image<std::uint8_t> labels;
  std::vector<HandTruth> hands;
};

/// The same in a mirror: a right hand becomes a left one, and says so.
ExactFrame mirrored(const ExactFrame& frame);

}  // namespace knuckle
