// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "knuckle/hand/hand_skeleton.h"
#include "knuckle/hand/skinning.h"

namespace knuckle {

/// The hand's axes in the body at rest: `body_from_hand(person) * point_in_hand` is in body axes [mm].
RigidTransform body_from_hand(const ShapedBody& person);

/// Where the hand of a posed body is, to hand over to `landmarks(HandSkeleton, ...)`. In single precision, as
/// posed bodies are. Throws as `bone_transforms` does.
RigidTransform camera_from_hand(const ShapedBody& person, const BodyPose& pose);

/// The right hand of a body as a skeleton, with the limits of healthy adults. Posed by the same angles, the
/// landmarks are those of the body (BodyRig) but for the single precision of posed bodies: about 0.001 mm.
/// Throws an Error where the body lacks a finger's bone, or a landmark or bone of the hand does not hang on
/// its wrist.R.
HandSkeleton skeleton_of(const ShapedBody& person, std::string name);

}  // namespace knuckle
