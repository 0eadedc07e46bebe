// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_distance.h"

#include <Eigen/Geometry>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/body_rig.h"
#include "knuckle/hand/skeleton_testing.h"
#include "knuckle/hand/testing_body.h"

namespace knuckle {
namespace {

/// Hands of many shapes, any way up.
std::vector<HandJoints> sampled_hands(int count, std::uint64_t seed) {
  const Body body = testing::box_hand_body();
  const ShapedBody person = shaped_body(body, std::vector<double>(body.shapedirs.size(), 0.0));
  const BodyRig rig(person);
  Random random(seed);
  std::vector<HandJoints> hands;
  for (int i = 0; i < count; ++i) {
    Eigen::Isometry3f camera_from_body = Eigen::Isometry3f::Identity();
    camera_from_body.linear() = Eigen::Quaternionf(Eigen::Quaterniond(random.normal(), random.normal(),
                                                                      random.normal(), random.normal())
                                                       .normalized()
                                                       .cast<float>())
                                    .toRotationMatrix();
    const HandAngles angles = testing::random_angles(healthy_limits(), random);
    hands.push_back(hand_joints(rig.landmarks(rig.pose({angles, {}}, camera_from_body))));
  }
  return hands;
}

HandJoints moved_hand(const HandJoints& hand) {
  const Eigen::AngleAxisd turn(2.5, Eigen::Vector3d(1, -2, 0.5).normalized());
  HandJoints result;
  for (int k = 0; k < kHandJoints; ++k) result[k] = 1.7 * (turn * hand[k]) + Point3(30, -200, 700);
  return result;
}

TEST(HandDistance, AMovedTurnedAndScaledHandIsTheSameShape) {
  for (const HandJoints& hand : sampled_hands(20, 1)) {
    EXPECT_NEAR(mean_distance_mm(hand, aligned_to(hand, moved_hand(hand))), 0.0, 1e-3);
    EXPECT_NEAR(HandSet(std::vector{moved_hand(hand)}).nearest(hand).distance_mm, 0.0, 0.01);
  }
}

TEST(HandDistance, AMirroredHandIsNot) {
  HandJoints hand = sampled_hands(1, 2).front();
  const HandSet set(std::vector{hand});
  for (Point3& joint : hand) joint.x() = -joint.x();
  EXPECT_GT(set.nearest(hand).distance_mm, 5.0);
  const HandJoints original = sampled_hands(1, 2).front();
  const HandJoints aligned = aligned_to(original, hand);
  EXPECT_GT(mean_distance_mm(original, aligned), 5.0);
  EXPECT_NEAR(mean_distance_mm(original, aligned), HandSet(std::vector{hand}).nearest(original).distance_mm,
              0.01);
}

TEST(HandDistance, HandsHaveAllLandmarksButThePalm) {
  std::array<Point3, kSupersetSize> landmarks;
  for (int i = 0; i < kSupersetSize; ++i) landmarks[static_cast<std::size_t>(i)] = Point3(i, 0, 0);
  const HandJoints joints = hand_joints(landmarks);
  EXPECT_EQ(joints[0].x(), 0.0);
  for (int k = 1; k < kHandJoints; ++k) EXPECT_EQ(joints[static_cast<std::size_t>(k)].x(), k + 1.0);
}

TEST(HandDistance, TheFastSearchFindsWhatTheSlowOneFinds) {
  const std::vector<HandJoints> hands = sampled_hands(1003, 3);  // not a whole number of blocks
  const HandSet set(hands);
  for (const HandJoints& target : sampled_hands(60, 4)) {
    NearestHand slow{1e9, -1};
    for (std::size_t i = 0; i < hands.size(); ++i) {
      const double distance = mean_distance_mm(target, aligned_to(target, hands[i]));
      if (distance < slow.distance_mm) slow = {distance, static_cast<std::int64_t>(i)};
    }
    const NearestHand fast = set.nearest(target);
    EXPECT_NEAR(fast.distance_mm, slow.distance_mm, 2e-3);
    EXPECT_EQ(fast.index, slow.index);
  }
}

TEST(HandDistance, RefusesWhatHasNoShape) {
  HandJoints hand;
  hand.fill(Point3(1, 2, 3));
  EXPECT_THAT(testing::error_of([&] { HandSet set(std::vector{hand}); }), ::testing::HasSubstr("coincide"));
  hand[3].x() = kNaN;
  EXPECT_THAT(testing::error_of([&] { HandSet set(std::vector{hand}); }), ::testing::HasSubstr("not finite"));
}

}  // namespace
}  // namespace knuckle
