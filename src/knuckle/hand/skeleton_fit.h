// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "knuckle/hand/hand_skeleton.h"

namespace knuckle {

/// A hand in a pose: the skeleton's angles, where its wrist is, and its size.
struct SkeletonPose {
  HandAngles angles;
  RigidTransform camera_from_hand = RigidTransform::Identity();
  double size = 1.0;  ///< factor on all of the skeleton's lengths, above 0
};

/// The 22 landmarks of a hand in a pose, in camera coordinates [mm].
std::array<Point3, kSupersetSize> landmarks(const HandSkeleton& skeleton, const SkeletonPose& pose);

/// Where a landmark was found, and how much that counts.
struct LandmarkTarget {
  Point3 point = Point3::Constant(kNaN);  ///< in camera coordinates [mm]; NaN where it was not found
  double weight = 1.0;                    ///< [0, inf); the deviation is `noise_mm` / sqrt(weight)
};
/// One per landmark, in the order of Landmark.
using LandmarkTargets = std::array<LandmarkTarget, kSupersetSize>;

/// What is known of a hand before it is seen: deviations of normal distributions.
struct SkeletonFitOptions {
  double noise_mm = 4.0;      ///< of a target of weight 1, (0, inf) [mm]
  double posture_rad = 0.8;   ///< of an angle around the hand at rest, (0, inf) [rad]
  double size_spread = 0.12;  ///< of the logarithm of the size around 0, [0, inf); 0: the size stays 1
  int most_steps = 40;        ///< at least 1
};

/// A skeleton fitted to landmarks.
struct SkeletonFit {
  SkeletonPose pose;    ///< its angles are within the skeleton's limits
  double rms_mm = 0.0;  ///< root mean square of the weighted distances to the targets [mm]
  double energy = 0.0;  ///< half the sum of all squared residuals, in deviations
  int steps = 0;        ///< that lowered it
};

/// Inverse kinematics: the pose of greatest posterior probability given the landmarks, by the method of
/// Levenberg and Marquardt with exact derivatives. Angles that reach a limit stay there while they are pushed
/// beyond it. It begins with `start`, or with the best of four postures, each laid on the targets as a rigid
/// body (Umeyama 1991). Nothing where fewer than three targets are known. Takes about 0.8 ms; allocates
/// nothing per step; safe to call from many threads. Throws an Error where an option is out of range, or a
/// weight is negative or not finite.
std::optional<SkeletonFit> fit_skeleton(const HandSkeleton& skeleton, const LandmarkTargets& targets,
                                        const SkeletonFitOptions& options = {},
                                        const std::optional<SkeletonPose>& start = std::nullopt);

}  // namespace knuckle
