// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/random.h"
#include "knuckle/hand/hand_skeleton.h"

namespace knuckle::testing {

/// A direction, uniform over the sphere.
Eigen::Vector3d random_direction(Random& random);

/// A turn and a shift of up to 1 m, any way.
RigidTransform random_pose(Random& random);

/// Angles anywhere within the limits.
HandAngles random_angles(const HandLimits& limits, Random& random);

/// A mechanism that passes `check` and has nothing else in common with a hand: joints, axes, shares, numbers
/// of turns and landmarks are random, no two alike.
HandSkeleton random_skeleton(Random& random);

}  // namespace knuckle::testing
