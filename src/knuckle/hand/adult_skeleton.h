// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/hand/hand_skeleton.h"

namespace knuckle {

/// The right hand of a mean adult, "adult", which needs no file: what `skeleton_of` finds in MakeHuman's body
/// half-way between woman and man, whose bones have the proportions of Buchholz, Armstrong and Goldstein
/// ("Anthropometric data for describing the kinematics of the human hand", Ergonomics 35, 1992). From the
/// wrist to the tip of the straight middle finger it is 186 mm long.
const HandSkeleton& adult_skeleton();

}  // namespace knuckle
