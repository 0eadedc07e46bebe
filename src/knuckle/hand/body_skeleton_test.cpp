// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/body_skeleton.h"

#include "knuckle/core/testing.h"
#include "knuckle/hand/body_rig.h"
#include "knuckle/hand/skeleton_testing.h"
#include "knuckle/hand/testing_body.h"

namespace knuckle {
namespace {

using Eigen::Matrix4d;

/// The box hand with joints and tips at rest pushed a few mm about: bent and twisted digits, none like
/// another.
class BodySkeletonTest : public ::testing::Test {
 protected:
  BodySkeletonTest() {
    Random random(11);
    for (Eigen::Vector3f& vertex : body_.v_template) {
      for (int k = 0; k < 3; ++k) vertex[k] += static_cast<float>(random.uniform(-5.0, 5.0));
    }
    // Joints and the landmarks at them stay together.
    for (int i = 0; i < kSupersetSize; ++i) {
      if ((i - 2) % 4 != 3 && i >= 2) {
        body_.landmark_regressor[i] = body_.joint_regressor[body_.landmark_bones[i]];
      }
    }
    person_ = shaped_body(body_, std::vector<double>{0.3, -0.4});
  }

  Body body_ = testing::box_hand_body();
  ShapedBody person_;
};

/// The body's landmarks in double precision: each bone a product of 4x4 matrices.
std::array<Point3, kSupersetSize> exact_landmarks(const ShapedBody& person, const HandAngles& angles) {
  const HandRig rig(person);
  std::vector<Matrix4d> turns(person.joints.size(), Matrix4d::Identity());
  for (const RigBone& bone : rig.bones()) {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    for (const BoneTurn& turn : bone.turns) {
      rotation *= Eigen::AngleAxisd(turn.share * angles[turn.angle], turn.axis).toRotationMatrix();
    }
    rotation *= Eigen::Quaterniond(bone.straighten).toRotationMatrix();
    const Point3 joint = person.joints[bone.bone].cast<double>();
    turns[bone.bone].topLeftCorner<3, 3>() = rotation;
    turns[bone.bone].topRightCorner<3, 1>() = joint - rotation * joint;
  }
  std::vector<Matrix4d> transforms(turns.size());
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const std::int32_t parent = person.body->parents[i];
    transforms[i] = (parent < 0 ? Matrix4d(Matrix4d::Identity()) : transforms[parent]) * turns[i];
  }
  std::array<Point3, kSupersetSize> points;
  for (int i = 0; i < kSupersetSize; ++i) {
    const Point3 at_rest = person.landmarks[i].cast<double>();
    points[i] = (transforms[person.body->landmark_bones[i]] * at_rest.homogeneous()).head<3>();
  }
  return points;
}

TEST_F(BodySkeletonTest, IsAHand) {
  const HandSkeleton skeleton = skeleton_of(person_, "box");
  check(skeleton);
  EXPECT_EQ(skeleton.name, "box");
  for (int i = 0; i < kSupersetSize; ++i) {
    EXPECT_EQ(skeleton.landmarks[i].bone, carrier_of(static_cast<Landmark>(i)));
  }
  const Point3 wrist = person_.landmarks[static_cast<std::size_t>(Landmark::wrist)].cast<double>();
  EXPECT_LT((body_from_hand(person_) * skeleton.landmarks[0].straight_mm - wrist).norm(), 1e-9);
}

TEST_F(BodySkeletonTest, MovesAsTheBodyDoes) {
  const HandSkeleton skeleton = skeleton_of(person_, "box");
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    HandAngles angles = testing::random_angles(healthy_limits(), random);
    if (trial % 2 == 1) {
      for (double& angle : angles.radians) angle *= 3.0;
    }
    const auto expected = exact_landmarks(person_, angles);
    const auto points = landmarks(skeleton, angles, body_from_hand(person_));
    for (int i = 0; i < kSupersetSize; ++i) EXPECT_LT((points[i] - expected[i]).norm(), 1e-6) << i;
  }
}

TEST_F(BodySkeletonTest, AgreesWithPosedBodiesToTheirPrecision) {
  const HandSkeleton skeleton = skeleton_of(person_, "box");
  const BodyRig rig(person_);
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const HandAngles angles = testing::random_angles(healthy_limits(), random);
    const ArmAngles arm{.supination = 0.5, .wrist_flexion = -0.3, .wrist_deviation = 0.2};
    const BodyPose pose =
        rig.pose({angles, arm}, Eigen::Isometry3f(testing::random_pose(random).cast<float>()));
    const auto expected = rig.landmarks(pose);
    const auto points = landmarks(skeleton, angles, camera_from_hand(person_, pose));
    for (int i = 0; i < kSupersetSize; ++i) EXPECT_LT((points[i] - expected[i]).norm(), 2e-3) << i;
  }
}

TEST_F(BodySkeletonTest, ABodyWithoutMetacarpalsHasAStiffPalm) {
  for (const char* name : {"metacarpal3.R", "metacarpal4.R"}) {
    body_.names[static_cast<std::size_t>(body_.bone(name))] = std::string("stiff ") + name;
  }
  const HandSkeleton skeleton = skeleton_of(person_, "stiff");
  check(skeleton);
  HandAngles arched;
  arched[HandAngle::palm_arch] = 0.4;
  EXPECT_EQ(landmarks(skeleton, arched, RigidTransform::Identity()),
            landmarks(skeleton, {}, RigidTransform::Identity()));
}

TEST_F(BodySkeletonTest, NamesWhatDoesNotHangOnTheWrist) {
  const int forearm = body_.bone("lowerarm02.R");
  body_.landmark_bones[static_cast<std::size_t>(Landmark::palm)] = forearm;
  EXPECT_THAT(testing::error_of([&] { skeleton_of(person_, "x"); }),
              ::testing::HasSubstr("palm does not hang"));
  body_.landmark_bones[static_cast<std::size_t>(Landmark::palm)] = body_.bone("wrist.R");
  body_.parents[static_cast<std::size_t>(body_.bone("finger1-1.R"))] = -1;
  EXPECT_THAT(testing::error_of([&] { skeleton_of(person_, "x"); }),
              ::testing::HasSubstr("thumb_metacarpal does not hang"));
}

}  // namespace
}  // namespace knuckle
