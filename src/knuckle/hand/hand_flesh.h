// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "knuckle/core/landmarks.h"

namespace knuckle {

/// Flesh around the line between two landmarks: a cone with round ends.
struct HandFlesh {
  Landmark from = Landmark::wrist;
  Landmark to = Landmark::wrist;
  double radius_from = 0.0;  ///< in parts of the distance from the wrist to the middle MCP
  double radius_to = 0.0;    ///< the same at its other end
};

/// Three pieces per digit and four in the palm.
inline constexpr int kFleshCount = 19;

/// The shape of a hand's skin, made of cones: three per digit from the thumb outwards, and before those of
/// each finger one from the wrist to its MCP. Fitted to what 300 frames of the generator's people show
/// (manifests/validate_network.toml): half of their pixels are within 1.7 mm of it.
const std::array<HandFlesh, kFleshCount>& hand_flesh();

}  // namespace knuckle
