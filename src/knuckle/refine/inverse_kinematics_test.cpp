// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/inverse_kinematics.h"

#include "knuckle/camera/projection.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"

namespace knuckle {
namespace {

constexpr Camera kCamera{.width = 320, .height = 240, .fx = 224, .fy = 230, .cx = 150, .cy = 120};

/// A hand that is a little closed, 500 mm before the camera.
std::array<Point3, kSupersetSize> points_of_hand() {
  SkeletonPose pose;
  for (int finger = 0; finger < 4; ++finger) pose.angles[angles_of_finger(finger).mcp] = 0.4;
  for (int finger = 0; finger < 4; ++finger) pose.angles[angles_of_finger(finger).pip] = 0.7 - 0.1 * finger;
  for (int finger = 0; finger < 4; ++finger) pose.angles[angles_of_finger(finger).dip] = 0.45 - 0.07 * finger;
  pose.angles[HandAngle::thumb_radial] = 0.4;
  pose.angles[HandAngle::thumb_palmar] = 0.6;
  pose.camera_from_hand.translation() = Point3(20, 60, 500);
  return landmarks(adult_skeleton(), pose);
}

HandPose pose_of(const std::array<Point3, kSupersetSize>& points, const char* convention) {
  HandPose pose = HandPose::missing(convention_from_name(convention));
  for (std::size_t i = 0; i < pose.joints.size(); ++i)
    pose.joints[i] =
        Projection(kCamera).to_image(points[static_cast<std::size_t>(pose.convention.landmarks[i])]);
  return pose;
}

HandPose refined(HandPose pose, const InverseKinematicsOptions& options = {}) {
  Frame frame;
  frame.camera = kCamera;
  return InverseKinematics(options).refine(frame, HandRegion{}, std::move(pose)).pose;
}

double distance_mm(const ImagePoint& joint, const Point3& point) {
  return (Projection(kCamera).to_camera(joint) - point).norm();
}

TEST(InverseKinematics, LeavesAHandNearlyAsItIs) {
  const auto points = points_of_hand();
  for (const char* convention : {"knuckle22", "icg20"}) {
    const HandPose pose = refined(pose_of(points, convention));
    for (std::size_t i = 0; i < pose.joints.size(); ++i)
      EXPECT_LT(distance_mm(pose.joints[i], points[static_cast<std::size_t>(pose.convention.landmarks[i])]),
                3.0)
          << i;
  }
}

TEST(InverseKinematics, BringsAnImpossibleJointBackAndTrustsTheSureOnes) {
  const auto points = points_of_hand();
  auto wrong = points;
  constexpr auto kWrong = static_cast<std::size_t>(Landmark::ring_dip);
  wrong[kWrong] += Point3(0, 0, -60);
  HandPose pose = pose_of(wrong, "knuckle22");
  EXPECT_LT(distance_mm(refined(pose).joints[kWrong], points[kWrong]), 45.0);
  pose.confidence.assign(pose.joints.size(), 1.0f);
  pose.confidence[kWrong] = 0.01f;
  const HandPose result = refined(pose);
  EXPECT_LT(distance_mm(result.joints[kWrong], points[kWrong]), 8.0);
  EXPECT_EQ(result.confidence, pose.confidence);
}

TEST(InverseKinematics, FillsJointsThatWereNotFoundWhereItMay) {
  const auto points = points_of_hand();
  constexpr auto kLost = static_cast<std::size_t>(Landmark::index_tip);
  HandPose pose = pose_of(points, "knuckle22");
  pose.joints[kLost] = ImagePoint{};
  EXPECT_LT(distance_mm(refined(pose).joints[kLost], points[kLost]), 15.0);
  EXPECT_TRUE(refined(pose, {.fill = false}).joints[kLost].is_missing());
}

TEST(InverseKinematics, WhatIsHardlyKnownComesBackUnchanged) {
  const HandPose whole = pose_of(points_of_hand(), "knuckle22");
  HandPose pose = HandPose::missing(superset_convention());
  pose.joints[0] = whole.joints[0];
  pose.joints[3] = whole.joints[3];
  const HandPose result = refined(pose);
  EXPECT_EQ(result.joints[0].u, pose.joints[0].u);
  EXPECT_EQ(result.joints[3].depth_mm, pose.joints[3].depth_mm);
  EXPECT_TRUE(result.joints[1].is_missing());
}

TEST(InverseKinematics, JointsThatNoSkeletonHasStay) {
  HandPose pose = HandPose::missing(convention_from_name("icvl16"));
  for (std::size_t i = 0; i < pose.joints.size(); ++i)
    pose.joints[i] = {100.0 + 3.0 * static_cast<double>(i), 90.0 + static_cast<double>(i * i % 7), 500.0};
  const HandPose result = refined(pose);
  for (std::size_t i = 0; i < pose.joints.size(); ++i) {
    if (static_cast<int>(pose.convention.landmarks[i]) < kSupersetSize) continue;
    EXPECT_EQ(result.joints[i].u, pose.joints[i].u) << i;
    EXPECT_EQ(result.joints[i].depth_mm, pose.joints[i].depth_mm) << i;
  }
}

TEST(InverseKinematics, RefusesOptionsOutOfRange) {
  EXPECT_THAT(testing::error_of([] { InverseKinematics({.noise_mm = 0.0}); }),
              ::testing::HasSubstr("noise_mm"));
  EXPECT_THAT(testing::error_of([] { InverseKinematics({.size_spread = 2.0}); }),
              ::testing::HasSubstr("size_spread"));
}

}  // namespace
}  // namespace knuckle
