// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "knuckle/core/pose.h"
#include "knuckle/core/transform.h"
#include "knuckle/hand/hand_angles.h"
#include "knuckle/hand/hand_bones.h"
#include "knuckle/hand/landmark_points.h"

namespace knuckle {

/// Turns that one joint may have.
inline constexpr std::size_t kMostTurns = 4;

/// A bone and the joint at its beginning, in the hand's axes, all angles 0.
struct SkeletonBone {
  int parent = -1;                   ///< number of the HandBone that carries it, less than its own; palm: -1
  Point3 joint_mm = Point3::Zero();  ///< centre of its turns [mm]
  std::vector<BoneTurn> turns;       ///< the first turns what the next have turned; none: fixed to its parent
};

/// One person's right hand as a mechanism: what poses landmarks by angles without a mesh.
///
/// The hand's axes: the origin is the wrist's joint, x points from the little finger's side to the thumb's,
/// y from the wrist to the middle finger's MCP, z out of the palm. All numbers are those of the straight
/// hand, HandAngles{}: the bones of each digit then lie on one line along y. `mirrored` makes a left hand,
/// which the same angles bend the same way.
struct HandSkeleton {
  std::string name;                                    ///< for people and files, for example "adult"
  std::array<SkeletonBone, kHandBoneCount> bones;      ///< in the order of HandBone
  std::array<LandmarkPoint, kSupersetSize> landmarks;  ///< in the order of Landmark
  HandLimits limits;                                   ///< of the angles
};

/// Throws an Error that starts with `what` and names field, value and bound: numbers that are not finite or
/// lie farther than 1 m from the wrist, a parent that does not come before its bone (a cycle), an axis that
/// is not of length 1 (within 1e-6), a share of 0, bones of digits shorter than 1 mm, limits that are
/// reversed or beyond a half turn.
void check(const HandSkeleton& skeleton, std::string_view what = "hand skeleton");

/// Derivatives of 22 landmarks: row 3 i + k is coordinate k of landmark i [mm]; a column for each parameter.
/// Columns 0 to 21 are the hand's angles [mm/rad]; then, as `moved` applies them, 3 of the wrist's turn
/// [mm/rad], 3 of its shift [mm/mm], and 1 of the hand's size: a factor about the wrist [mm].
using LandmarkJacobian = Eigen::Matrix<double, 3 * kSupersetSize, kHandAngleCount + 7, Eigen::DontAlign>;
inline constexpr int kTurnColumn = kHandAngleCount;       ///< first column of the wrist's turn
inline constexpr int kShiftColumn = kHandAngleCount + 3;  ///< first column of the wrist's shift
inline constexpr int kSizeColumn = kHandAngleCount + 6;   ///< the column of the hand's size

/// Where each bone is: takes points of the straight hand, in the hand's axes, to camera coordinates [mm].
/// In the order of HandBone.
std::array<RigidTransform, kHandBoneCount> bone_poses(const HandSkeleton& skeleton, const HandAngles& angles,
                                                      const RigidTransform& camera_from_hand);

/// The 22 landmarks in camera coordinates [mm], in the order of Landmark; with `jacobian`, their exact
/// derivatives too. Angles may lie beyond their limits, but have to be finite, as the skeleton (`check`).
/// Allocates nothing; safe to call from many threads.
std::array<Point3, kSupersetSize> landmarks(const HandSkeleton& skeleton, const HandAngles& angles,
                                            const RigidTransform& camera_from_hand,
                                            LandmarkJacobian* jacobian = nullptr);

/// The pose after a small step: turned about the wrist by the rotation vector `turn` [rad], in camera axes
/// (exp(turn) R: from the left), then shifted by `shift` [mm]. `landmarks` gives derivatives at a step of 0.
RigidTransform moved(const RigidTransform& camera_from_hand, const Eigen::Vector3d& turn,
                     const Eigen::Vector3d& shift);

/// The hand with all lengths multiplied by `factor`, above 0.
HandSkeleton scaled(HandSkeleton skeleton, double factor);

/// The same hand of the other side: reflected in x. The same angles bend it as its mirror image.
HandSkeleton mirrored(HandSkeleton skeleton);

/// Lengths of the bones of the digits [mm]: thumb to little, each from the palm outwards, the last to the
/// tip.
std::array<std::array<double, 3>, 5> digit_lengths_mm(const HandSkeleton& skeleton);

}  // namespace knuckle
