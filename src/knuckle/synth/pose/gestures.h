// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "knuckle/hand/hand_angles.h"

namespace knuckle {

/// A hand shape with a name.
struct Gesture {
  std::string_view name;
  HandAngles angles;
};

/// All named gestures.
std::span<const Gesture> gestures();

/// The gesture of that name. Throws an Error that lists the known ones.
const Gesture& gesture_from_name(std::string_view name);

}  // namespace knuckle
