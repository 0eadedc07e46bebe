// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/landmarks.h"
#include "knuckle/core/pose.h"
#include "knuckle/hand/hand_bones.h"

namespace knuckle {

/// Where a landmark lies on a hand: fixed to one bone.
struct LandmarkPoint {
  HandBone bone = HandBone::palm;
  Point3 straight_mm = Point3::Zero();  ///< in the hand's axes, all angles 0 [mm]; see HandSkeleton
};

/// The bone that carries a landmark of the superset: a joint lies on the bone beyond it, at its head; a
/// finger tip on its digit's last bone; wrist and palm on the palm. Throws an Error where the landmark
/// belongs to one data set alone.
HandBone carrier_of(Landmark landmark);

/// The landmark at the beginning of a digit's bone (`joint` 0 to 2 from the palm outwards), or the digit's
/// tip (3). Digits: 0 thumb to 4 little.
Landmark landmark_of_digit(int digit, int joint);

}  // namespace knuckle
