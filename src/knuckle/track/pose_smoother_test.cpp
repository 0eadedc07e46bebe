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

class PoseSmootherTest : public ::testing::TestWithParam<std::string> {
 protected:
  PoseSmoother smoother{{.smoothing = GetParam()}};
};
INSTANTIATE_TEST_SUITE_P(Smoothings, PoseSmootherTest, ::testing::Values("one_euro", "kalman"),
                         [](const auto& test) { return test.param; });

TEST_P(PoseSmootherTest, LeavesAStillHandAsItIs) {
  Random random(1);
  SkeletonPose pose;
  pose.camera_from_hand = testing::random_pose(random);
  pose.angles = testing::random_angles(healthy_limits(), random);
  pose.size = 1.1;
  for (int i = 0; i < 4; ++i) {
    const SkeletonPose smoothed = smoother.smooth(pose, kFrame_s);
    EXPECT_LT((smoothed.camera_from_hand.matrix() - pose.camera_from_hand.matrix()).norm(), 1e-9);
    for (std::size_t k = 0; k < pose.angles.radians.size(); ++k)
      EXPECT_NEAR(smoothed.angles.radians[k], pose.angles.radians[k], 1e-12);
    EXPECT_EQ(smoothed.size, 1.1);
  }
}

TEST_P(PoseSmootherTest, TurnsThroughAllAnglesWithoutASeam) {
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

TEST_P(PoseSmootherTest, TakesTheTremblingFromAHandThatRests) {
  Random random(2);
  const RigidTransform rest = testing::random_pose(random);
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

TEST_P(PoseSmootherTest, KeepsAnglesWithinTheirLimits) {
  for (int i = 0; i < 60; ++i) {  // bends ever faster, and stops at a limit
    SkeletonPose pose;
    pose.angles[HandAngle::index_pip] = std::min(0.001 * i * i, 1.5);
    pose.angles = clamped(pose.angles);
    EXPECT_TRUE(within_limits(smoother.smooth(pose, kFrame_s).angles)) << i;
  }
}

TEST(PoseSmoother, TheWristIsAveragedWhileTheDigitsMove) {
  Random random(6);
  PoseSmoother smoother({.smoothing = "kalman"});
  double squares = 0.0;
  for (int i = 0; i < 300; ++i) {
    SkeletonPose pose;
    pose.camera_from_hand.translation() = Point3(random.normal(), random.normal(), random.normal());
    for (double& angle : pose.angles.radians) angle = 0.4 + 0.4 * std::sin(12.0 * i * kFrame_s);
    const SkeletonPose smoothed = smoother.smooth(pose, kFrame_s);
    if (i >= 60) squares += smoothed.camera_from_hand.translation().squaredNorm() / 3.0 / 240.0;
  }
  EXPECT_LT(std::sqrt(squares), 0.3) << "of 1 mm";
}

TEST(PoseSmoother, WithoutSmoothingAnswersWhatItGot) {
  PoseSmoother smoother({.smoothing = "none"});
  for (const double angle : {0.1, 0.9, 0.3}) {
    SkeletonPose pose;
    pose.angles[HandAngle::index_pip] = angle;
    EXPECT_EQ(smoother.smooth(pose, kFrame_s).angles[HandAngle::index_pip], angle);
  }
}

TEST(PoseSmoother, StrengthSmoothsMore) {
  const auto trembling = [](const std::string& smoothing, double strength) {
    Random random(3);
    PoseSmoother smoother({.smoothing = smoothing, .strength = strength});
    double squares = 0.0;
    for (int i = 0; i < 200; ++i) {
      SkeletonPose pose;
      pose.camera_from_hand.translation() = 2.0 * Point3(random.normal(), random.normal(), random.normal());
      if (i >= 60)
        squares += smoother.smooth(pose, kFrame_s).camera_from_hand.translation().squaredNorm();
      else
        smoother.smooth(pose, kFrame_s);
    }
    return squares;
  };
  for (const char* const smoothing : {"one_euro", "kalman"}) {
    EXPECT_LT(trembling(smoothing, 2.0), 0.9 * trembling(smoothing, 0.5)) << smoothing;
  }
}

}  // namespace
}  // namespace knuckle
