// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/hand_model.h"

#include <cmath>

#include "knuckle/camera/projection.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/hand_collision.h"
#include "knuckle/hand/hand_flesh.h"
#include "knuckle/hand/skeleton_testing.h"
#include "knuckle/refine/inverse_kinematics.h"
#include "knuckle/refine/skeleton_pose.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;
using Points = std::array<Point3, kSupersetSize>;

constexpr Camera kHandCamera{.width = 320, .height = 240, .fx = 270, .fy = 275, .cx = 150, .cy = 120};

/// A hand with bent fingers, its palm towards the camera.
Points hand_before_camera(double bend) {
  SkeletonPose pose;
  for (int finger = 0; finger < 4; ++finger) {
    pose.angles[angles_of_finger(finger).mcp] = bend;
    pose.angles[angles_of_finger(finger).pip] = bend - 0.1 * finger;
    pose.angles[angles_of_finger(finger).dip] = coupled_dip(bend - 0.1 * finger);
  }
  pose.angles[HandAngle::thumb_radial] = 0.5;
  pose.angles[HandAngle::thumb_palmar] = 0.4;
  pose.camera_from_hand.linear() = Eigen::DiagonalMatrix<double, 3>(-1.0, 1.0, -1.0);
  pose.camera_from_hand.translation() = Point3(10, -60, 500);
  return landmarks(adult_skeleton(), pose);
}

/// Draws the nearer of what is there and a sphere.
void draw_sphere(const Point3& centre, double radius, Frame& frame) {
  const Projection projection(frame.camera);
  for (int row = 0; row < frame.depth_mm.height(); ++row) {
    for (int column = 0; column < frame.depth_mm.width(); ++column) {
      const Point3 ray =
          projection.to_camera({static_cast<double>(column), static_cast<double>(row), 1.0}).normalized();
      const double along = ray.dot(centre);
      const double half = radius * radius - (centre.squaredNorm() - along * along);
      if (half <= 0.0) continue;
      const auto depth = static_cast<float>((along - std::sqrt(half)) * ray.z());
      float& pixel = frame.depth_mm(column, row);
      if (pixel == 0.0f || depth < pixel) pixel = depth;
    }
  }
}

/// The flesh of a hand before a wall.
Frame frame_of(const Points& points) {
  Frame frame;
  frame.camera = kHandCamera;
  frame.depth_mm = Image<float>(kHandCamera.width, kHandCamera.height, 900.0f);
  const double palm = (points[static_cast<std::size_t>(Landmark::middle_mcp)] - points[0]).norm();
  for (const HandFlesh& flesh : hand_flesh()) {
    for (double share = 0.0; share <= 1.0; share += 0.125) {
      draw_sphere((1.0 - share) * points[static_cast<std::size_t>(flesh.from)] +
                      share * points[static_cast<std::size_t>(flesh.to)],
                  ((1.0 - share) * flesh.radius_from + share * flesh.radius_to) * palm, frame);
    }
  }
  return frame;
}

HandPose pose_at(const Points& points) {
  HandPose pose = HandPose::missing(superset_convention());
  for (std::size_t i = 0; i < points.size(); ++i)
    pose.joints[i] = Projection(kHandCamera).to_image(points[i]);
  return pose;
}

double mean_error_mm(const HandPose& pose, const Points& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    sum += (Projection(kHandCamera).to_camera(pose.joints[i]) - truth[i]).norm();
  return sum / kSupersetSize;
}

TEST(HandModel, TheDepthImageMakesJointsBetterThanTheSkeletonAlone) {
  Random random(1);
  double with_depth = 0.0;
  double without = 0.0;
  for (const double bend : {0.1, 0.5, 0.9}) {
    const Points truth = hand_before_camera(bend);
    const Frame frame = frame_of(truth);
    for (int trial = 0; trial < 4; ++trial) {
      // What networks do wrong: all joints of a finger lean one way.
      Points wrong = truth;
      const Eigen::Vector3d all = 5.0 * testing::random_direction(random);
      for (std::size_t i = 0; i < wrong.size(); ++i) {
        const double reach = i < 2 ? 0.3 : 0.3 + 0.3 * static_cast<double>((i - 2) % 4);
        wrong[i] += all + 8.0 * reach * testing::random_direction(random);
      }
      with_depth +=
          mean_error_mm(HandModel({.length_spread = 0.0}).refine(frame, {}, pose_at(wrong)).pose, truth);
      without += mean_error_mm(InverseKinematics({}).refine(frame, {}, pose_at(wrong)).pose, truth);
    }
  }
  EXPECT_LT(with_depth, 0.8 * without) << with_depth / 12 << " mm, " << without / 12 << " mm";
}

TEST(HandModel, TakesItsOptionsAtTheirWord) {
  const Points truth = hand_before_camera(0.4);
  Points wrong = truth;
  constexpr int kIndexPip = static_cast<int>(Landmark::index_pip);
  constexpr int kMiddlePip = static_cast<int>(Landmark::middle_pip);
  for (int i = 0; i < 3; ++i) wrong[kIndexPip + i] = truth[kMiddlePip + i];  // in one another
  const auto refined = [&](const HandModelOptions& options) {
    const HandPose pose = HandModel(options).refine(frame_of(truth), {}, pose_at(wrong)).pose;
    Points points;
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] = Projection(kHandCamera).to_camera(pose.joints[i]);
    return points;
  };
  EXPECT_GT(worst_penetration_mm(refined({.overlap_mm = 0.0})),
            2.0 + worst_penetration_mm(refined({.overlap_mm = 0.2})));
  // The first bone of the finger, which both its ends have elsewhere.
  const auto miss_of_bone = [&](double bone_mm) {
    const Points points = refined({.bone_mm = bone_mm, .overlap_mm = 0.0});
    return ((points[kIndexPip] - points[kIndexPip - 1]) - (wrong[kIndexPip] - wrong[kIndexPip - 1])).norm();
  };
  EXPECT_LT(miss_of_bone(0.5), 0.8 * miss_of_bone(0.0));
}

TEST(HandModel, AFingerThatFloatsIsBroughtBack) {
  const Points truth = hand_before_camera(0.8);
  Points wrong = truth;
  const Points straight = hand_before_camera(0.1);
  constexpr int kIndexMcp = static_cast<int>(Landmark::index_mcp);
  for (int i = kIndexMcp; i < kIndexMcp + 4; ++i) wrong[i] = straight[i];  // stretched out before the wall
  HandPose pose = pose_at(wrong);
  pose.confidence.assign(pose.joints.size(), 1.0f);
  for (int i = kIndexMcp; i < kIndexMcp + 4; ++i) pose.confidence[i] = 0.2f;  // it was guessed
  const double with_depth = mean_error_mm(HandModel({}).refine(frame_of(truth), {}, pose).pose, truth);
  EXPECT_LT(with_depth,
            0.75 * mean_error_mm(InverseKinematics({}).refine(frame_of(truth), {}, pose).pose, truth))
      << with_depth;
}

TEST(HandModel, AnEmptyFrameLeavesInverseKinematics) {
  const Points truth = hand_before_camera(0.4);
  for (const float depth : {0.0f, 5000.0f}) {
    Frame frame = frame_of(truth);
    frame.depth_mm = Image<float>(kHandCamera.width, kHandCamera.height, depth);
    const HandPose model =
        HandModel({.bone_mm = 0.0, .length_spread = 0.0}).refine(frame, {}, pose_at(truth)).pose;
    const HandPose joints_alone = InverseKinematics({}).refine(frame, {}, pose_at(truth)).pose;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_EQ(model.joints[i].u, joints_alone.joints[i].u) << i;
      EXPECT_EQ(model.joints[i].depth_mm, joints_alone.joints[i].depth_mm) << i;
    }
  }
}

TEST(HandModel, AnswersTheAnglesOfItsSkeleton) {
  const Points truth = hand_before_camera(0.5);
  const RefinedHand result = HandModel({}).refine(frame_of(truth), {}, pose_at(truth));
  ASSERT_TRUE(result.angles);
  EXPECT_EQ(result.skeleton, "adult");
  EXPECT_TRUE(within_limits(*result.angles));
  EXPECT_NEAR((*result.angles)[HandAngle::index_mcp], 0.5, 0.1);
  EXPECT_NEAR((*result.angles)[HandAngle::little_pip], 0.2, 0.1);
}

TEST(HandModel, WhatFitsNoHandIsLessPlausible) {
  const Points truth = hand_before_camera(0.5);
  const double of_hand = HandModel({}).refine(frame_of(truth), {}, pose_at(truth)).plausibility;
  EXPECT_GT(of_hand, 0.9);
  // The same joints before a wavy wall.
  Frame wall = frame_of(truth);
  for (int row = 0; row < wall.depth_mm.height(); ++row) {
    for (int column = 0; column < wall.depth_mm.width(); ++column)
      wall.depth_mm(column, row) =
          static_cast<float>(485.0 + 25.0 * std::sin(0.2 * column) * std::cos(0.17 * row));
  }
  EXPECT_LT(HandModel({}).refine(wall, {}, pose_at(truth)).plausibility, 0.9 * of_hand);
  // A hand half as large as an adult's; a child's is plausible.
  const auto of_size = [&](double size) {
    Points points = truth;
    for (Point3& point : points) point = truth[0] + size * (point - truth[0]);
    return HandModel({.size_spread = 1.0}).refine(frame_of(points), {}, pose_at(points)).plausibility;
  };
  EXPECT_GT(of_size(0.78), 0.85);
  EXPECT_LT(of_size(0.45), 0.3);
}

TEST(HandModel, WhatIsHardlyKnownComesBackUnchanged) {
  const RefinedHand result =
      HandModel({}).refine(frame_of(hand_before_camera(0.3)), {}, HandPose::missing(superset_convention()));
  EXPECT_TRUE(result.pose.is_missing());
  EXPECT_FALSE(result.angles);
}

TEST(HandModel, ConfidencesOf0AreNoJoints) {
  const Points truth = hand_before_camera(0.3);
  HandPose pose = pose_at(truth);
  pose.confidence.assign(pose.joints.size(), 0.0f);
  const HandPose result = HandModel({}).refine(frame_of(truth), {}, pose).pose;
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(result.joints[i].u, pose.joints[i].u) << i;
}

TEST(HandModel, RefusesOptionsOutOfRange) {
  EXPECT_THAT(testing::error_of([] { HandModel({.surface_mm = 0.0}); }), HasSubstr("surface_mm"));
  EXPECT_THAT(testing::error_of([] { HandModel({.bone_mm = -1.0}); }), HasSubstr("bone_mm"));
  EXPECT_THAT(testing::error_of([] { HandModel({.overlap_mm = -1.0}); }), HasSubstr("overlap_mm"));
  EXPECT_THAT(testing::error_of([] { HandModel({.length_spread = 2.0}); }), HasSubstr("length_spread"));
}

}  // namespace
}  // namespace knuckle
