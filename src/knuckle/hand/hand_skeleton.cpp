// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_skeleton.h"

#include <cmath>
#include <cstddef>

#include "knuckle/core/error.h"
#include "knuckle/hand/rotation_between.h"

namespace knuckle {
namespace {

using Eigen::Vector3d;

/// Axes of the hinges in camera coordinates.
using PosedAxes = std::array<std::array<Vector3d, kMostTurns>, kHandBoneCount>;

struct PosedHand {
  std::array<RigidTransform, kHandBoneCount> bones;
  PosedAxes axes;  ///< of each bone's turns
};

/// Poses a bone that stands as its parent does: turns it about its joint, noting the axes on the way.
void turn_bone(RigidTransform& pose, std::array<Vector3d, kMostTurns>& axes, const SkeletonBone& bone,
               const HandAngles& angles) {
  if (bone.turns.size() > kMostTurns) {
    fail("hand skeleton: a bone has {} turns, expected at most {}", bone.turns.size(), kMostTurns);
  }
  const Point3 joint = pose * bone.joint_mm;
  Eigen::Matrix3d rotation = pose.linear();
  for (std::size_t k = 0; k < bone.turns.size(); ++k) {
    const BoneTurn& turn = bone.turns[k];
    axes[k] = rotation * turn.axis;
    rotation *= rotation_about(turn.share * angles[turn.angle], turn.axis).toRotationMatrix();
  }
  pose.linear() = rotation;
  pose.translation() = joint - rotation * bone.joint_mm;
}

PosedHand posed_hand(const HandSkeleton& skeleton, const HandAngles& angles,
                     const RigidTransform& camera_from_hand) {
  PosedHand posed;
  for (int i = 0; i < kHandBoneCount; ++i) {
    const SkeletonBone& bone = skeleton.bones[i];
    posed.bones[i] = bone.parent < 0 ? camera_from_hand : posed.bones[bone.parent];
    turn_bone(posed.bones[i], posed.axes[i], bone, angles);
  }
  return posed;
}

/// The columns of the angles: each hinge between a landmark and the palm moves it by axis x (point - joint).
void add_angle_columns(LandmarkJacobian& jacobian, int row, const HandSkeleton& skeleton,
                       const PosedHand& posed, HandBone carrier, const Point3& point) {
  for (int i = static_cast<int>(carrier); i >= 0; i = skeleton.bones[i].parent) {
    const SkeletonBone& bone = skeleton.bones[i];
    if (bone.turns.empty()) continue;
    const Vector3d from_joint = point - posed.bones[i] * bone.joint_mm;
    for (std::size_t k = 0; k < bone.turns.size(); ++k) {
      const BoneTurn& turn = bone.turns[k];
      jacobian.block<3, 1>(row, static_cast<int>(turn.angle)) +=
          turn.share * posed.axes[i][k].cross(from_joint);
    }
  }
}

/// The columns of the wrist's pose and of the hand's size.
void add_wrist_columns(LandmarkJacobian& jacobian, int row, const Vector3d& from_wrist) {
  for (int k = 0; k < 3; ++k) {
    const Vector3d unit = Vector3d::Unit(k);
    jacobian.block<3, 1>(row, kTurnColumn + k) = unit.cross(from_wrist);
    jacobian.block<3, 1>(row, kShiftColumn + k) = unit;
  }
  jacobian.block<3, 1>(row, kSizeColumn) = from_wrist;
}

LandmarkJacobian jacobian_of(const HandSkeleton& skeleton, const PosedHand& posed,
                             const std::array<Point3, kSupersetSize>& points, const Point3& wrist) {
  LandmarkJacobian jacobian = LandmarkJacobian::Zero();
  for (int i = 0; i < kSupersetSize; ++i) {
    add_angle_columns(jacobian, 3 * i, skeleton, posed, skeleton.landmarks[i].bone, points[i]);
    add_wrist_columns(jacobian, 3 * i, points[i] - wrist);
  }
  return jacobian;
}

Vector3d reflected(const Vector3d& vector) {
  return {-vector.x(), vector.y(), vector.z()};
}

}  // namespace

std::array<RigidTransform, kHandBoneCount> bone_poses(const HandSkeleton& skeleton, const HandAngles& angles,
                                                      const RigidTransform& camera_from_hand) {
  return posed_hand(skeleton, angles, camera_from_hand).bones;
}

std::array<Point3, kSupersetSize> landmarks(const HandSkeleton& skeleton, const HandAngles& angles,
                                            const RigidTransform& camera_from_hand,
                                            LandmarkJacobian* jacobian) {
  const PosedHand posed = posed_hand(skeleton, angles, camera_from_hand);
  std::array<Point3, kSupersetSize> points;
  for (int i = 0; i < kSupersetSize; ++i) {
    const LandmarkPoint& landmark = skeleton.landmarks[i];
    points[i] = posed.bones[static_cast<std::size_t>(landmark.bone)] * landmark.straight_mm;
  }
  if (jacobian != nullptr) *jacobian = jacobian_of(skeleton, posed, points, camera_from_hand.translation());
  return points;
}

RigidTransform moved(const RigidTransform& camera_from_hand, const Vector3d& turn, const Vector3d& shift) {
  RigidTransform result = camera_from_hand;
  const double angle = turn.norm();
  if (angle > 0.0) {
    result.linear() = rotation_about(angle, turn / angle).toRotationMatrix() * camera_from_hand.linear();
  }
  result.translation() += shift;
  return result;
}

HandSkeleton scaled(HandSkeleton skeleton, double factor) {
  if (!(factor > 0.0) || !std::isfinite(factor)) {
    fail("hand skeleton '{}': scaled by {}, expected a finite factor above 0", skeleton.name, factor);
  }
  for (SkeletonBone& bone : skeleton.bones) bone.joint_mm *= factor;
  for (LandmarkPoint& landmark : skeleton.landmarks) landmark.straight_mm *= factor;
  return skeleton;
}

HandSkeleton mirrored(HandSkeleton skeleton) {
  for (SkeletonBone& bone : skeleton.bones) {
    bone.joint_mm = reflected(bone.joint_mm);
    // A mirror turns a rotation about its axis around.
    for (BoneTurn& turn : bone.turns) turn.axis = -reflected(turn.axis);
  }
  for (LandmarkPoint& landmark : skeleton.landmarks) landmark.straight_mm = reflected(landmark.straight_mm);
  return skeleton;
}

std::array<std::array<double, 3>, 5> digit_lengths_mm(const HandSkeleton& skeleton) {
  const auto at = [&](int digit, int joint) {
    return skeleton.landmarks[static_cast<std::size_t>(landmark_of_digit(digit, joint))].straight_mm;
  };
  std::array<std::array<double, 3>, 5> lengths;
  for (int digit = 0; digit < 5; ++digit) {
    for (int joint = 0; joint < 3; ++joint) {
      lengths[digit][joint] = (at(digit, joint + 1) - at(digit, joint)).norm();
    }
  }
  return lengths;
}

}  // namespace knuckle
