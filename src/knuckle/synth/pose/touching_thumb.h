// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/hand/hand_angles.h"

namespace knuckle {

/// Angles of a thumb: the first ones of HandAngle.
inline constexpr int kThumbAngleCount = 5;

/// Where a thumb's tip touches a finger.
struct ThumbContact {
  int finger = 0;           ///< 0 index, 1 middle, 2 ring, 3 little
  int bone = 2;             ///< of that finger: 0 proximal, 1 middle, 2 distal
  double along = 0.7;       ///< place on the bone: 0 its joint, 1 its other end
  double distance_mm = 15;  ///< of the landmarks inside: as thick as the pads between them are, above 0 [mm]
};

/// The hand with its thumb bent so that the tip of a mean adult's (`adult_skeleton`) touches the finger: the
/// angles of least squares in the distance [deviation 1 mm] and in the difference from the thumb that `hand`
/// has [deviation 22 degrees of the metacarpal, 14 of its twist, 18 of the MCP, 7 of the IP], within the
/// limits of the joints. A thumb that cannot reach the finger comes as near as it can:
/// `distance_from_contact_mm` tells.
HandAngles with_touching_thumb(const HandAngles& hand, const ThumbContact& contact);

/// How far the thumb's tip is from the distance that the contact asks for, on a mean adult [mm].
double distance_from_contact_mm(const HandAngles& hand, const ThumbContact& contact);

}  // namespace knuckle
