// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include "knuckle/hand/body.h"

namespace knuckle::testing {

/// A right forearm and hand of boxes and square tubes, closed, about 190 mm long, with the names of the bones
/// that the real body has from lowerarm02.R on, and two shape directions: "longer" (all along y by a tenth)
/// and "thumb". It hangs from the elbow at (0, 250, 0), finger tips down, palm to the front (+z), thumb to
/// the body's right (-x).
Body box_hand_body();

/// The same hand on a whole arm, with the bones of the real body from upperarm01.R on: the shoulder is at
/// (0, 530, 40), the elbow, at rest bent a little, at (0, 250, 0), lowerarm02.R begins at (0, 125, 0).
Body box_arm_body();

}  // namespace knuckle::testing
