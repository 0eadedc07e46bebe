// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_skeleton.h"

#include <cmath>
#include <functional>
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/skeleton_testing.h"

namespace knuckle {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using testing::random_angles;
using testing::random_pose;
using testing::random_skeleton;
using Points = std::array<Point3, kSupersetSize>;

constexpr int kTrials = 20;

/// Angles far beyond what a hand can take.
HandAngles wild_angles(Random& random) {
  HandAngles angles;
  for (double& angle : angles.radians) angle = random.uniform(-3.0, 3.0);
  return angles;
}

/// Distance of two sets of points: the largest of all coordinates [mm].
double largest_difference(const Points& a, const Points& b) {
  double largest = 0.0;
  for (int i = 0; i < kSupersetSize; ++i) {
    largest = std::max(largest, (a[i] - b[i]).lpNorm<Eigen::Infinity>());
  }
  return largest;
}

Matrix4d shift_by(const Vector3d& shift) {
  Matrix4d matrix = Matrix4d::Identity();
  matrix.topRightCorner<3, 1>() = shift;
  return matrix;
}

/// Rodrigues' formula.
Matrix4d rotation_about(const Vector3d& axis, double angle) {
  Eigen::Matrix3d cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  Matrix4d matrix = Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() += std::sin(angle) * cross + (1.0 - std::cos(angle)) * cross * cross;
  return matrix;
}

/// What `bone` does to points of the straight hand: a product of 4x4 matrices from the palm outwards.
Matrix4d motion_of(const HandSkeleton& skeleton, const HandAngles& angles, int bone) {
  if (bone < 0) return Matrix4d::Identity();
  Matrix4d motion = motion_of(skeleton, angles, skeleton.bones[bone].parent);
  motion *= shift_by(skeleton.bones[bone].joint_mm);
  for (const BoneTurn& turn : skeleton.bones[bone].turns) {
    motion *= rotation_about(turn.axis, turn.share * angles[turn.angle]);
  }
  return motion * shift_by(-skeleton.bones[bone].joint_mm);
}

TEST(HandSkeletonTest, IsAProductOfMatrices) {
  Random random(1);
  for (int trial = 0; trial < kTrials; ++trial) {
    const HandSkeleton skeleton = random_skeleton(random);
    const HandAngles angles = wild_angles(random);
    const RigidTransform pose = random_pose(random);
    Points expected;
    for (int i = 0; i < kSupersetSize; ++i) {
      const LandmarkPoint& landmark = skeleton.landmarks[i];
      const Matrix4d motion = pose.matrix() * motion_of(skeleton, angles, static_cast<int>(landmark.bone));
      expected[i] = (motion * landmark.straight_mm.homogeneous()).head<3>();
    }
    EXPECT_LT(largest_difference(landmarks(skeleton, angles, pose), expected), 1e-9);
  }
}

/// All parameters of `landmarks`, moved by a step of one of them.
struct Parameters {
  HandSkeleton skeleton;
  HandAngles angles;
  RigidTransform pose;

  Points landmarks_after(int column, double step) const {
    if (column < kTurnColumn) {
      HandAngles other = angles;
      other.radians[column] += step;
      return landmarks(skeleton, other, pose);
    }
    if (column == kSizeColumn) return landmarks(scaled(skeleton, 1.0 + step), angles, pose);
    Eigen::Matrix<double, 6, 1> twist = Eigen::Matrix<double, 6, 1>::Zero();
    twist[column - kTurnColumn] = step;
    return landmarks(skeleton, angles, moved(pose, twist.head<3>(), twist.tail<3>()));
  }
};

void expect_derivatives_of_differences(const Parameters& at) {
  constexpr double kStep = 1e-5;
  LandmarkJacobian jacobian;
  landmarks(at.skeleton, at.angles, at.pose, &jacobian);
  const double size = jacobian.cwiseAbs().maxCoeff();
  for (int column = 0; column < jacobian.cols(); ++column) {
    const Points after = at.landmarks_after(column, kStep);
    const Points before = at.landmarks_after(column, -kStep);
    for (int i = 0; i < kSupersetSize; ++i) {
      const Vector3d difference = (after[i] - before[i]) / (2.0 * kStep);
      const Vector3d derivative = jacobian.block<3, 1>(3 * i, column);
      EXPECT_LT((difference - derivative).norm(), 1e-6 * std::max(1.0, size)) << column << " " << i;
    }
  }
}

TEST(HandSkeletonTest, DerivativesAreThoseOfFiniteDifferences) {
  Random random(2);
  for (int trial = 0; trial < kTrials; ++trial) {
    const HandSkeleton skeleton = random_skeleton(random);
    const RigidTransform pose = random_pose(random);
    expect_derivatives_of_differences({skeleton, random_angles(skeleton.limits, random), pose});
    expect_derivatives_of_differences({skeleton, wild_angles(random), pose});
  }
  expect_derivatives_of_differences({adult_skeleton(), {}, random_pose(random)});
}

TEST(HandSkeletonTest, AJacobianChangesNoLandmark) {
  Random random(3);
  const HandAngles angles = random_angles(healthy_limits(), random);
  const RigidTransform pose = random_pose(random);
  LandmarkJacobian jacobian = LandmarkJacobian::Constant(5.0);  // what was there before does not matter
  const Points with = landmarks(adult_skeleton(), angles, pose, &jacobian);
  EXPECT_EQ(with, landmarks(adult_skeleton(), angles, pose));
  LandmarkJacobian again = LandmarkJacobian::Zero();
  landmarks(adult_skeleton(), angles, pose, &again);
  EXPECT_EQ(jacobian, again);
}

TEST(HandSkeletonTest, FollowsTheWristRigidly) {
  Random random(4);
  for (int trial = 0; trial < kTrials; ++trial) {
    const HandSkeleton skeleton = random_skeleton(random);
    const HandAngles angles = wild_angles(random);
    const RigidTransform pose = random_pose(random);
    Points expected = landmarks(skeleton, angles, RigidTransform::Identity());
    for (Point3& point : expected) point = pose * point;
    EXPECT_LT(largest_difference(landmarks(skeleton, angles, pose), expected), 1e-9);
  }
}

TEST(HandSkeletonTest, AMirroredHandIsTheMirrorImage) {
  Random random(5);
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  mirror(0, 0) = -1.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const HandSkeleton skeleton = random_skeleton(random);
    const HandAngles angles = wild_angles(random);
    const RigidTransform pose = random_pose(random);
    RigidTransform mirrored_pose = pose;
    mirrored_pose.linear() = mirror * pose.linear() * mirror;
    mirrored_pose.translation() = mirror * pose.translation();
    Points expected = landmarks(skeleton, angles, pose);
    for (Point3& point : expected) point = mirror * point;
    EXPECT_LT(largest_difference(landmarks(mirrored(skeleton), angles, mirrored_pose), expected), 1e-9);
  }
}

TEST(HandSkeletonTest, LengthsStayUnderAllAngles) {
  Random random(6);
  const auto lengths = digit_lengths_mm(adult_skeleton());
  for (int trial = 0; trial < kTrials; ++trial) {
    const Points points = landmarks(adult_skeleton(), wild_angles(random), random_pose(random));
    for (int digit = 0; digit < 5; ++digit) {
      for (int joint = 0; joint < 3; ++joint) {
        const auto first = static_cast<std::size_t>(landmark_of_digit(digit, joint));
        EXPECT_NEAR((points[first + 1] - points[first]).norm(), lengths[digit][joint], 1e-9);
      }
    }
  }
}

TEST(HandSkeletonTest, SizeIsAFactorAboutTheWrist) {
  Random random(7);
  const HandSkeleton skeleton = random_skeleton(random);
  const HandAngles angles = wild_angles(random);
  const RigidTransform pose = random_pose(random);
  Points expected = landmarks(skeleton, angles, pose);
  const Point3 wrist = pose.translation();
  for (Point3& point : expected) point = wrist + 1.7 * (point - wrist);
  EXPECT_LT(largest_difference(landmarks(scaled(skeleton, 1.7), angles, pose), expected), 1e-9);
  for (const double factor : {0.0, -1.0, kNaN, std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(testing::error_of([&] { scaled(skeleton, factor); }), ::testing::HasSubstr("above 0"));
  }
}

TEST(HandSkeletonTest, AStepTurnsAboutTheWrist) {
  Random random(8);
  const RigidTransform pose = random_pose(random);
  const Vector3d turn(0.3, -0.5, 0.2);
  const RigidTransform after = moved(pose, turn, {1, 2, 3});
  EXPECT_TRUE(after.translation().isApprox(pose.translation() + Vector3d(1, 2, 3)));
  EXPECT_TRUE((after.linear() * pose.linear().transpose() * turn).isApprox(turn));  // its own axis stays
  const Eigen::Matrix3d relative = after.linear() * pose.linear().transpose();
  EXPECT_NEAR(relative.trace(), 1.0 + 2.0 * std::cos(turn.norm()), 1e-12);
  EXPECT_EQ(moved(pose, Vector3d::Zero(), Vector3d::Zero()).matrix(), pose.matrix());
}

TEST(HandSkeletonTest, LandmarksLieOnTheirBones) {
  Random random(9);
  const HandSkeleton skeleton = random_skeleton(random);
  const HandAngles angles = wild_angles(random);
  const auto poses = bone_poses(skeleton, angles, random_pose(random));
  EXPECT_TRUE(poses[3].linear().isUnitary(1e-12));
  Random again(9);
  random_skeleton(again);
  wild_angles(again);
  const Points points = landmarks(skeleton, angles, random_pose(again));
  for (int i = 0; i < kSupersetSize; ++i) {
    const LandmarkPoint& landmark = skeleton.landmarks[i];
    EXPECT_EQ(points[i], poses[static_cast<std::size_t>(landmark.bone)] * landmark.straight_mm);
  }
}

/// The message of `check` for the adult after `change`.
std::string fault_after(const std::function<void(HandSkeleton&)>& change) {
  HandSkeleton skeleton = adult_skeleton();
  change(skeleton);
  return testing::error_of([&] { check(skeleton, "file.model"); });
}

SkeletonBone& bone_of(HandSkeleton& skeleton, HandBone bone) {
  return skeleton.bones[static_cast<std::size_t>(bone)];
}

TEST(HandSkeletonTest, ChecksPassForHands) {
  Random random(10);
  check(adult_skeleton());
  check(mirrored(adult_skeleton()));
  check(scaled(adult_skeleton(), 0.7));
  for (int trial = 0; trial < kTrials; ++trial) check(random_skeleton(random));
}

TEST(HandSkeletonTest, ChecksNameBoneAndBound) {
  using ::testing::HasSubstr;
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::index_middle).joint_mm.y() = kNaN; }),
              HasSubstr("file.model 'adult': joint_mm of index_middle is ("));
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::index_middle).joint_mm.x() = 2000; }),
              HasSubstr("within 1000 mm"));
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::thumb_distal).parent = 5; }),
              HasSubstr("the parent of thumb_distal is 5, expected a bone before it, 0 to 4"));
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::thumb_distal).parent = -1; }),
              HasSubstr("the parent of thumb_distal is -1"));
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::palm).parent = 0; }),
              HasSubstr("the parent of palm is 0, expected -1"));
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::ring_distal).turns[0].axis *= 1.001; }),
              HasSubstr("the axis of ring_dip of ring_distal is"));
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::ring_distal).turns[0].axis.x() = kNaN; }),
              HasSubstr("expected a length of 1"));
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::ring_distal).turns[0].share = 0.0; }),
              HasSubstr("the share of ring_dip of ring_distal is 0"));
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::ring_distal).turns[0].share = kNaN; }),
              HasSubstr("is nan"));
  EXPECT_THAT(fault_after([](auto& s) {
                bone_of(s, HandBone::ring_distal).turns[0].angle = static_cast<HandAngle>(22);
              }),
              HasSubstr("has angle 22, expected one of 22"));
  EXPECT_THAT(fault_after([](auto& s) { bone_of(s, HandBone::ring_distal).turns.resize(5); }),
              HasSubstr("ring_distal has 5 turns, expected at most 4"));
  HandSkeleton unchecked = adult_skeleton();
  bone_of(unchecked, HandBone::ring_distal).turns.resize(5);
  EXPECT_THAT(testing::error_of([&] { landmarks(unchecked, {}, RigidTransform::Identity()); }),
              HasSubstr("a bone has 5 turns, expected at most 4"));
}

TEST(HandSkeletonTest, ChecksNameLandmarkLengthAndLimit) {
  using ::testing::HasSubstr;
  const auto tip = static_cast<std::size_t>(Landmark::little_tip);
  EXPECT_THAT(fault_after([&](auto& s) { s.landmarks[tip].straight_mm.z() = kNaN; }),
              HasSubstr("straight_mm of little_tip is ("));
  EXPECT_THAT(fault_after([&](auto& s) { s.landmarks[tip].bone = static_cast<HandBone>(18); }),
              HasSubstr("the bone of little_tip is 18, expected one of 18"));
  EXPECT_THAT(fault_after([&](auto& s) { s.landmarks[tip] = s.landmarks[tip - 1]; }),
              HasSubstr("little_distal is 0 mm long, expected at least 1 mm"));
  EXPECT_THAT(fault_after([](auto& s) { std::swap(s.limits.ranges[0].low, s.limits.ranges[0].high); }),
              HasSubstr("limits of thumb_radial are"));
  EXPECT_THAT(fault_after([](auto& s) { s.limits.ranges[21].high = kNaN; }),
              HasSubstr("limits of palm_arch"));
  EXPECT_THAT(fault_after([](auto& s) { s.limits.dip_above_coupling = -0.1; }),
              HasSubstr("dip_above_coupling is -0.1"));
  EXPECT_THAT(fault_after([](auto& s) { s.limits.spread_left_when_bent = 1.5; }),
              HasSubstr("spread_left_when_bent is 1.5, expected 0 to 1"));
}

}  // namespace
}  // namespace knuckle
