// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "knuckle/core/camera.h"
#include "knuckle/core/random.h"
#include "knuckle/hand/body_rig.h"
#include "knuckle/synth/scene/placement_options.h"

namespace knuckle {

/// A random arm within the limits of its joints.
ArmAngles sampled_arm(const PlacementOptions& options, Random& random);

/// A posture seen by a camera.
struct PlacedPosture {
  Posture posture;
  Eigen::Isometry3f camera_from_body = Eigen::Isometry3f::Identity();
};

/// How much is wrong with a view of a hand: 0 where all landmarks lie in the image (of a hand that may be
/// cut: most) and nothing of the body is before the hand. In millimetres and pixels, for comparisons only.
double violation(const BodyRig& rig, const BodyPose& pose, const Camera& camera,
                 const PlacementOptions& options, double allowed_outside);

/// How far a hand is from being presented, in degrees beyond what the options allow: 0 for a hand held up
/// with its palm to the camera.
double presentation_violation(const std::array<Point3, kSupersetSize>& landmarks,
                              const PlacementOptions& options);

/// Finds an arm and a place for this hand: the first of up to 200 random ones with which nothing is wrong,
/// else the best.
PlacedPosture sampled_placement(const BodyRig& rig, const HandAngles& hand, const Camera& camera,
                                const PlacementOptions& options, Random& random);

}  // namespace knuckle
