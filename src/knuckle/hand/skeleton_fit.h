// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "knuckle/hand/hand_skeleton.h"
#include "knuckle/hand/hand_surface.h"

namespace knuckle {

/// One number per bone of the digits: thumb to little, each from the palm outwards.
using DigitNumbers = std::array<std::array<double, 3>, 5>;
/// All 1: factors that change nothing.
inline constexpr DigitNumbers kOnes = {{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};

/// A hand in a pose: the skeleton's angles, where its wrist is, its size and the proportions of its digits.
struct SkeletonPose {
  HandAngles angles;
  RigidTransform camera_from_hand = RigidTransform::Identity();
  double size = 1.0;             ///< factor on all of the skeleton's lengths, above 0
  DigitNumbers lengths = kOnes;  ///< factors on the lengths of the digits' bones besides, above 0
};

/// The 22 landmarks of a hand in a pose, in camera coordinates [mm].
std::array<Point3, kSupersetSize> landmarks(const HandSkeleton& skeleton, const SkeletonPose& pose);

/// Where a landmark was found, and how much that counts.
struct LandmarkTarget {
  Point3 point = Point3::Constant(kNaN);  ///< in camera coordinates [mm]; NaN where it was not found
  double weight = 1.0;                    ///< [0, inf); the deviation is `noise_mm` / sqrt(weight)
  double depth_weight = 1.0;  ///< [0, inf); factor on `weight` along the line of sight, from the origin
};
/// One per landmark, in the order of Landmark.
using LandmarkTargets = std::array<LandmarkTarget, kSupersetSize>;

/// What is known of a hand before it is seen: means and deviations of normal distributions, of sizes and
/// lengths those of their logarithms.
struct SkeletonFitOptions {
  double noise_mm = 4.0;  ///< of a target of weight 1, (0, inf) [mm]
  /// Of the way from one target of a digit to the next, of weight 1, [0, inf) [mm]; 0: it is not asked. An
  /// estimator's errors are alike along a digit: how that is bent is surer than where it lies.
  double bone_mm = 0.0;
  double posture_spread = 1.0;              ///< factor on the deviations of PosturePrior, (0, inf)
  std::optional<HandAngles> expected = {};  ///< angles, where a moment before says what they should be
  double expected_rad = 0.2;                ///< of an angle around what is expected, (0, inf) [rad]
  double size = 1.0;                        ///< mean of SkeletonPose::size, (0, inf)
  double size_spread = 0.12;                ///< [0, inf); 0: the size is known
  DigitNumbers lengths = kOnes;             ///< means of SkeletonPose::lengths, (0, inf)
  double length_spread = 0.07;              ///< [0, inf); 0: the lengths are known
  double surface_mm = 3.0;  ///< of measured points from the skin, (0, inf) [mm]; all count as 22 landmarks
  /// Of how deep two digits, or a digit and the palm, run into one another beyond the 6 mm that soft flesh
  /// gives way, [0, inf) [mm]; 0: it is not asked.
  double overlap_mm = 0.0;
  int most_steps = 40;  ///< at least 1
};

/// A skeleton fitted to landmarks.
struct SkeletonFit {
  SkeletonPose pose;    ///< its angles are within the skeleton's limits
  double rms_mm = 0.0;  ///< root mean square of the weighted distances to the targets [mm]
  double gap_mm =
      kNaN;  ///< mean distance of the surface's points from the skin, none more than 8 mm; NaN: no points
  double energy = 0.0;  ///< half the sum of all squared residuals, in deviations
  int steps = 0;        ///< that lowered it
};

/// Inverse kinematics: the pose of greatest posterior probability given the landmarks, by the method of
/// Levenberg and Marquardt with exact derivatives. Angles that reach a limit stay there while they are pushed
/// beyond it. It begins with `start`, or with the best of four postures, each laid on the targets as a rigid
/// body (Umeyama 1991). Nothing where fewer than three targets are known. Takes about 0.8 ms; allocates
/// nothing per step; safe to call from many threads. Throws an Error where an option is out of range, or a
/// weight is negative or not finite, or a point of the surface is not finite.
///
/// With a `surface`, the skin is drawn to its points, and flesh that floats before what was measured to the
/// nearest of them; a point that is far from the skin counts little (Geman and McClure 1985), since it may be
/// another thing's.
std::optional<SkeletonFit> fit_skeleton(const HandSkeleton& skeleton, const LandmarkTargets& targets,
                                        const SkeletonFitOptions& options = {},
                                        const std::optional<SkeletonPose>& start = std::nullopt,
                                        const HandSurface& surface = {});

}  // namespace knuckle
