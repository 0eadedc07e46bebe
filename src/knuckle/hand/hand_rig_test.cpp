// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_rig.h"

#include <cmath>
#include <numbers>

#include "knuckle/core/testing.h"
#include "knuckle/hand/body_rig.h"
#include "knuckle/hand/testing_body.h"

namespace knuckle {
namespace {

using Eigen::Vector3d;

class HandRigTest : public ::testing::Test {
 protected:
  std::array<Point3, kSupersetSize> landmarks(const HandAngles& angles) const {
    BodyPose pose;
    pose.rotations.assign(body_.names.size(), Eigen::Quaternionf::Identity());
    for (const auto& [bone, rotation] : rig_.rotations(angles)) pose.rotations[bone] = rotation;
    return posed_body(person_, pose).landmarks;
  }

  /// Direction of part 0 (next to the palm) to 2 of digit 0 (thumb) to 4, in the hand's axes.
  Vector3d direction(const HandAngles& angles, int digit, int part) const {
    const auto points = landmarks(angles);
    const int first = static_cast<int>(Landmark::thumb_cmc) + 4 * digit + part;
    return rig_.axes_at_rest().transpose() * (points[first + 1] - points[first]).normalized();
  }

  Body body_ = testing::box_hand_body();
  ShapedBody person_ = shaped_body(body_, std::vector<double>(body_.shapedirs.size(), 0.0));
  HandRig rig_{person_};
  static constexpr double kTolerance = 1e-4;
};

constexpr double kRightAngle = std::numbers::pi / 2.0;

TEST_F(HandRigTest, AxesAreOrthonormalAndRightHanded) {
  EXPECT_TRUE(rig_.axes_at_rest().isUnitary(1e-9));
  EXPECT_NEAR(rig_.axes_at_rest().determinant(), 1.0, 1e-9);
  // The test body hangs: finger tips down, palm to the front, thumb to the body's right.
  EXPECT_GT(rig_.axes_at_rest().col(0).dot(Vector3d(-1, 0, 0)), 0.9);
  EXPECT_GT(rig_.axes_at_rest().col(1).dot(Vector3d(0, -1, 0)), 0.9);
  EXPECT_GT(rig_.axes_at_rest().col(2).dot(Vector3d(0, 0, 1)), 0.9);
}

TEST_F(HandRigTest, NoAnglesAreAStraightHand) {
  for (int digit = 0; digit < 5; ++digit) {
    for (int part = 0; part < 3; ++part) {
      EXPECT_TRUE(direction({}, digit, part).isApprox(Vector3d(0, 1, 0), 1e-3)) << digit << " " << part;
    }
  }
}

TEST_F(HandRigTest, FlexionBendsTowardsThePalm) {
  for (int finger = 0; finger < 4; ++finger) {
    const FingerAngleNames names = angles_of_finger(finger);
    HandAngles angles;
    angles[names.mcp] = kRightAngle;
    EXPECT_GT(direction(angles, finger + 1, 0).z(), 0.98);
    EXPECT_GT(direction(angles, finger + 1, 2).z(), 0.98);  // the rest of the finger goes along
    angles[names.pip] = kRightAngle;
    EXPECT_LT(direction(angles, finger + 1, 1).y(), -0.98);  // back towards the wrist
    angles = {};
    angles[names.dip] = kRightAngle;
    EXPECT_GT(direction(angles, finger + 1, 1).y(), 0.98);
    EXPECT_GT(direction(angles, finger + 1, 2).z(), 0.98);
  }
}

TEST_F(HandRigTest, EachJointTurnsByItsAngle) {
  for (int finger = 0; finger < 4; ++finger) {
    const FingerAngleNames names = angles_of_finger(finger);
    HandAngles angles;
    angles[names.mcp] = 0.7;
    angles[names.spread] = 0.2;
    angles[names.pip] = 0.9;
    angles[names.dip] = 0.4;
    const Vector3d first = direction(angles, finger + 1, 0);
    const Vector3d second = direction(angles, finger + 1, 1);
    const Vector3d third = direction(angles, finger + 1, 2);
    EXPECT_NEAR(std::acos(first.dot(second)), 0.9, 1e-3);
    EXPECT_NEAR(std::acos(second.dot(third)), 0.4, 1e-3);
    EXPECT_NEAR(std::acos(first.dot(third)), 1.3, 1e-3);  // in one plane
  }
}

TEST_F(HandRigTest, SpreadLeadsAwayFromTheMiddleFinger) {
  for (int finger = 0; finger < 4; ++finger) {
    HandAngles angles;
    angles[angles_of_finger(finger).spread] = 0.3;
    const Vector3d along = direction(angles, finger + 1, 1);
    EXPECT_NEAR(along.x(), (finger <= 1 ? 1.0 : -1.0) * std::sin(0.3), 0.01);
    EXPECT_NEAR(along.y(), std::cos(0.3), 0.01);
  }
}

TEST_F(HandRigTest, TheThumbGoesWhereItsAnglesSay) {
  HandAngles angles;
  angles[HandAngle::thumb_radial] = 0.6;
  angles[HandAngle::thumb_palmar] = 0.8;
  const Vector3d expected(std::cos(0.8) * std::sin(0.6), std::cos(0.8) * std::cos(0.6), std::sin(0.8));
  for (int part = 0; part < 3; ++part) EXPECT_TRUE(direction(angles, 0, part).isApprox(expected, 1e-3));
  angles[HandAngle::thumb_ip] = 0.5;
  EXPECT_TRUE(direction(angles, 0, 1).isApprox(expected, 1e-3));
  EXPECT_NEAR(std::acos(direction(angles, 0, 2).dot(expected)), 0.5, 1e-3);
}

TEST_F(HandRigTest, BonesKeepTheirLengths) {
  HandAngles bent;
  for (int i = 0; i < kHandAngleCount; ++i) bent.radians[i] = 0.1 + 0.02 * i;
  const auto straight = landmarks({});
  const auto points = landmarks(clamped(bent));
  for (int digit = 0; digit < 5; ++digit) {
    const int first = static_cast<int>(Landmark::thumb_cmc) + 4 * digit;
    for (int part = 0; part < 3; ++part) {
      EXPECT_NEAR((points[first + part + 1] - points[first + part]).norm(),
                  (straight[first + part + 1] - straight[first + part]).norm(), 1e-3);
    }
  }
}

TEST_F(HandRigTest, NamesAMissingBone) {
  Body body = testing::box_hand_body();
  body.names[static_cast<std::size_t>(body.bone("finger4-2.R"))] = "other";
  const ShapedBody person = shaped_body(body, std::vector<double>(body.shapedirs.size(), 0.0));
  EXPECT_THAT(testing::error_of([&] { HandRig rig(person); }), ::testing::HasSubstr("finger4-2.R"));
}

TEST_F(HandRigTest, TheWristBendsTowardsThePalmAndTheLittleFinger) {
  const BodyRig rig(person_);
  const auto forward = [&](const ArmAngles& arm) {
    const BodyPose pose = rig.pose({{}, arm}, Eigen::Isometry3f::Identity());
    return Vector3d(hand_axes(rig.landmarks(pose)).col(1));
  };
  const Vector3d straight = forward({});
  const Vector3d palmar = rig_.axes_at_rest().col(2);
  const Vector3d radial = rig_.axes_at_rest().col(0);
  const Vector3d flexed = forward({.wrist_flexion = 0.5});
  EXPECT_NEAR(std::acos(flexed.dot(straight)), 0.5, 1e-3);
  EXPECT_GT((flexed - straight).dot(palmar), 0.3);
  const Vector3d deviated = forward({.wrist_deviation = 0.3});
  EXPECT_NEAR(std::acos(deviated.dot(straight)), 0.3, 1e-3);
  EXPECT_LT((deviated - straight).dot(radial), -0.2);
}

}  // namespace
}  // namespace knuckle
