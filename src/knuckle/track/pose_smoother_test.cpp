// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/pose_smoother.h"

#include <cmath>

#include <Eigen/Geometry>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/skeleton_testing.h"

namespace knuckle {
namespace {

constexpr double kFrame_s = 1.0 / 30.0;

double angle_between(const RigidTransform& a, const RigidTransform& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

TEST(PoseSmoother, LeavesAStillHandAsItIs) {
  Random random(1);
  SkeletonPose pose;
  pose.camera_from_hand = testing::random_pose(random);
  pose.angles = testing::random_angles(healthy_limits(), random);
  pose.size = 1.1;
  PoseSmoother smoother({});
  for (int i = 0; i < 4; ++i) {
    const SkeletonPose smoothed = smoother.smooth(pose, kFrame_s);
    EXPECT_LT((smoothed.camera_from_hand.matrix() - pose.camera_from_hand.matrix()).norm(), 1e-9);
    for (std::size_t k = 0; k < pose.angles.radians.size(); ++k)
      EXPECT_NEAR(smoothed.angles.radians[k], pose.angles.radians[k], 1e-12);
    EXPECT_EQ(smoothed.size, 1.1);
  }
}

TEST(PoseSmoother, TurnsThroughAllAnglesWithoutASeam) {
  PoseSmoother smoother({});
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -0.5).normalized();
  for (int i = 0; i < 200; ++i) {  // 2 rad/s: two turns
    SkeletonPose pose;
    pose.camera_from_hand.linear() = Eigen::AngleAxisd(2.0 * i * kFrame_s, axis).toRotationMatrix();
    const SkeletonPose smoothed = smoother.smooth(pose, kFrame_s);
    EXPECT_LT(angle_between(pose.camera_from_hand, smoothed.camera_from_hand), 0.2) << i;
    EXPECT_NEAR((smoothed.camera_from_hand.linear().transpose() * smoothed.camera_from_hand.linear() -
                 Eigen::Matrix3d::Identity())
                    .norm(),
                0.0, 1e-9);
  }
}

TEST(PoseSmoother, TakesTheTremblingFromAHandThatRests) {
  Random random(2);
  const RigidTransform rest = testing::random_pose(random);
  PoseSmoother smoother({});
  double before = 0.0;
  double after = 0.0;
  for (int i = 0; i < 600; ++i) {
    SkeletonPose pose;
    pose.camera_from_hand = rest;
    pose.camera_from_hand.translation() += Point3(random.normal(), random.normal(), random.normal());
    pose.camera_from_hand.linear() =
        rest.linear() *
        Eigen::AngleAxisd(0.02 * random.normal(), testing::random_direction(random)).toRotationMatrix();
    pose.angles[HandAngle::index_pip] = 0.5 + 0.05 * random.normal();
    const SkeletonPose smoothed = smoother.smooth(pose, kFrame_s);
    if (i < 60) continue;
    const auto error = [&](const SkeletonPose& of) {
      return (of.camera_from_hand.translation() - rest.translation()).squaredNorm() +
             std::pow(50.0 * angle_between(of.camera_from_hand, rest), 2) +
             std::pow(20.0 * (of.angles[HandAngle::index_pip] - 0.5), 2);
    };
    before += error(pose);
    after += error(smoothed);
  }
  EXPECT_LT(std::sqrt(after / before), 0.5);
}

}  // namespace
}  // namespace knuckle
