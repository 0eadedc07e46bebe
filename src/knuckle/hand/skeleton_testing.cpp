// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/skeleton_testing.h"

namespace knuckle::testing {
namespace {

Point3 random_point(Random& random) {
  return 100.0 * Point3(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
}

SkeletonBone random_bone(int number, Random& random) {
  SkeletonBone bone;
  bone.parent = number == 0 ? -1 : static_cast<int>(random.below(static_cast<std::uint32_t>(number)));
  bone.joint_mm = random_point(random);
  const std::uint32_t turns = number == 0 ? 0 : random.below(kMostTurns + 1);
  for (std::uint32_t k = 0; k < turns; ++k) {
    bone.turns.push_back({static_cast<HandAngle>(random.below(kHandAngleCount)), random.uniform(-1.5, 1.5),
                          random_direction(random)});
  }
  return bone;
}

}  // namespace

Eigen::Vector3d random_direction(Random& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

RigidTransform random_pose(Random& random) {
  RigidTransform pose = RigidTransform::Identity();
  pose.linear() = Eigen::AngleAxisd(random.uniform(-3.0, 3.0), random_direction(random)).toRotationMatrix();
  pose.translation() = 10.0 * random_point(random);
  return pose;
}

HandAngles random_angles(const HandLimits& limits, Random& random) {
  HandAngles angles;
  for (int i = 0; i < kHandAngleCount; ++i) {
    angles.radians[i] = random.uniform(limits.ranges[i].low, limits.ranges[i].high);
  }
  return clamped(angles, limits);
}

HandSkeleton random_skeleton(Random& random) {
  HandSkeleton skeleton;
  skeleton.name = "random";
  skeleton.limits = healthy_limits();
  for (int i = 0; i < kHandBoneCount; ++i) skeleton.bones[i] = random_bone(i, random);
  for (LandmarkPoint& landmark : skeleton.landmarks) {
    landmark = {static_cast<HandBone>(random.below(kHandBoneCount)), random_point(random)};
  }
  return skeleton;
}

}  // namespace knuckle::testing
