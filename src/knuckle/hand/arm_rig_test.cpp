// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/arm_rig.h"

#include "knuckle/core/angle.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/testing_body.h"

namespace knuckle {
namespace {

using Eigen::Vector3d;

/// Body axes: x to the body's left, y up, z to the front.
const Vector3d kUp(0, 1, 0);
const Vector3d kForward(0, 0, 1);
const Vector3d kRight(-1, 0, 0);

class ArmRigTest : public ::testing::Test {
 protected:
  BodyPose pose(const ArmAngles& angles) const {
    BodyPose result;
    result.rotations.assign(body_.names.size(), Eigen::Quaternionf::Identity());
    for (const auto& [bone, rotation] : rig_.rotations(angles)) result.rotations[bone] = rotation;
    return result;
  }

  /// The direction, at rest, of the bone called `name`, as the pose turns it.
  Vector3d turned(const ArmAngles& angles, std::string_view name, const Vector3d& at_rest) const {
    const Eigen::Matrix4f transform = bone_transforms(person_, pose(angles))[body_.bone(name)];
    return (transform.topLeftCorner<3, 3>() * at_rest.cast<float>()).cast<double>();
  }

  Vector3d joint(const ArmAngles& angles, std::string_view name) const {
    const int bone = body_.bone(name);
    const Eigen::Matrix4f transform = bone_transforms(person_, pose(angles))[bone];
    return (transform * person_.joints[bone].homogeneous()).head<3>().cast<double>();
  }

  Vector3d forearm(const ArmAngles& angles) const {
    return (joint(angles, "wrist.R") - joint(angles, "lowerarm01.R")).normalized();
  }
  Vector3d upper_arm(const ArmAngles& angles) const {
    return (joint(angles, "lowerarm01.R") - joint(angles, "upperarm01.R")).normalized();
  }

  /// The hand's axes, posed: radial, forward, palmar.
  Eigen::Matrix3d hand(const ArmAngles& angles) const {
    return hand_axes(posed_body(person_, pose(angles)).landmarks);
  }

  Body body_ = testing::box_arm_body();
  ShapedBody person_ = shaped_body(body_, std::vector<double>(body_.shapedirs.size(), 0.0));
  ArmRig rig_{person_};
  static constexpr double kTolerance = 1e-4;
};

TEST_F(ArmRigTest, AnArmThatHangsBendsForward) {
  const ArmAngles bent{.elbow_flexion = 90 * kDegree};
  EXPECT_LT((upper_arm(bent) + kUp).norm(), kTolerance);
  EXPECT_LT((forearm(bent) - kForward).norm(), kTolerance);
  EXPECT_LT((forearm(ArmAngles{}) + kUp).norm(), kTolerance) << "0 is a straight arm";
}

TEST_F(ArmRigTest, TheShoulderRaisesTheUpperArmAsideAndForward) {
  const ArmAngles aside{.shoulder_elevation = 90 * kDegree};
  EXPECT_LT((upper_arm(aside) - kRight).norm(), kTolerance);
  const ArmAngles forward{.shoulder_elevation = 90 * kDegree, .shoulder_azimuth = 90 * kDegree};
  EXPECT_LT((upper_arm(forward) - kForward).norm(), kTolerance);
}

TEST_F(ArmRigTest, TheUpperArmTurnsInwards) {
  const ArmAngles inwards{.humeral_rotation = 60 * kDegree, .elbow_flexion = 90 * kDegree};
  EXPECT_NEAR(forearm(inwards).dot(kForward), std::cos(60 * kDegree), kTolerance);
  EXPECT_NEAR(forearm(inwards).dot(kRight), -std::sin(60 * kDegree), kTolerance);
}

TEST_F(ArmRigTest, SupinationTurnsTheThumbFromAboveAndThePalmUp) {
  for (const double degrees : {-80.0, 0.0, 35.0, 80.0}) {
    const double angle = degrees * kDegree;
    const Eigen::Matrix3d axes = hand({.elbow_flexion = 90 * kDegree, .supination = angle});
    EXPECT_LT((axes.col(1) - kForward).norm(), kTolerance) << degrees;
    EXPECT_NEAR(axes.col(0).dot(kUp), std::cos(angle), kTolerance) << degrees;
    EXPECT_NEAR(axes.col(2).dot(kUp), std::sin(angle), kTolerance) << degrees;
  }
}

TEST_F(ArmRigTest, AThirdOfTheForearmsTwistIsNextToTheElbow) {
  const double angle = 60 * kDegree;
  const Vector3d along = (person_.joints[body_.bone("wrist.R")] - person_.joints[body_.bone("lowerarm01.R")])
                             .cast<double>()
                             .normalized();
  const auto twist = [&](std::string_view bone) {
    const ArmAngles from{.elbow_flexion = 90 * kDegree};
    const ArmAngles to{.elbow_flexion = 90 * kDegree, .supination = angle};
    const Vector3d across = along.unitOrthogonal();
    return std::acos(turned(from, bone, across).dot(turned(to, bone, across)));
  };
  EXPECT_NEAR(twist("lowerarm01.R"), 0.35 * angle, 1e-3);
  EXPECT_NEAR(twist("lowerarm02.R"), angle, 1e-3);
}

TEST_F(ArmRigTest, TheWristBendsTowardsPalmAndLittleFinger) {
  const ArmAngles thumb_up{.elbow_flexion = 90 * kDegree};
  ArmAngles flexed = thumb_up;
  flexed.wrist_flexion = 40 * kDegree;
  EXPECT_NEAR(hand(flexed).col(1).dot(kForward), std::cos(40 * kDegree), kTolerance);
  EXPECT_NEAR(hand(flexed).col(1).dot(hand(thumb_up).col(2)), std::sin(40 * kDegree), kTolerance);
  ArmAngles deviated = thumb_up;
  deviated.wrist_deviation = 20 * kDegree;
  EXPECT_NEAR(hand(deviated).col(1).dot(kUp), -std::sin(20 * kDegree), kTolerance);
}

TEST_F(ArmRigTest, AHandAloneTurnsAtItsWristOnly) {
  const Body alone = testing::box_hand_body();
  const ShapedBody person = shaped_body(alone, std::vector<double>(alone.shapedirs.size(), 0.0));
  const std::vector<BoneRotation> rotations =
      ArmRig(person).rotations({.shoulder_elevation = 0.5, .elbow_flexion = 1.0, .supination = 0.3});
  ASSERT_EQ(rotations.size(), 1U);
  EXPECT_EQ(rotations[0].bone, alone.bone("wrist.R"));
}

}  // namespace
}  // namespace knuckle
