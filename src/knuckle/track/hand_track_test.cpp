// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/hand_track.h"

#include <Eigen/Geometry>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

SkeletonPose pose_at(double x_mm) {
  SkeletonPose pose;
  pose.camera_from_hand.translation() = Point3(x_mm, 0.0, 500.0);
  return pose;
}

TEST(HandTrack, AnEstimateOfTheOtherSideCountsOnceItIsOutvoted) {
  HandTrack track(1, 0.0, {});
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(track.agree_on_side(HandSide::right, 0.1));
  track.move_to(pose_at(0.0), 0.2);
  EXPECT_FALSE(track.agree_on_side(HandSide::left, 0.3));
  EXPECT_FALSE(track.agree_on_side(HandSide::left, 0.4));
  EXPECT_TRUE(track.is_seen_at(0.2)) << "it is followed as before";
  EXPECT_EQ(track.begun_s, 0.0);
  EXPECT_TRUE(track.agree_on_side(HandSide::left, 0.5));
  EXPECT_EQ(track.side(), HandSide::left);
  EXPECT_EQ(track.begun_s, 0.5) << "it was the other hand all the time";
  EXPECT_FALSE(track.pose);
}

TEST(HandTrack, ASteadyMotionIsPredicted) {
  constexpr double kMmPerSecond = 300.0;
  HandTrack track(1, 0.0, {});
  for (int i = 0; i < 60; ++i) track.move_to(pose_at(kMmPerSecond * i / 30.0), i / 30.0);
  const Eigen::Vector3d shift = track.shift_until(track.seen_s + 0.1);
  EXPECT_NEAR(shift.x(), 0.1 * kMmPerSecond, 0.1);
  EXPECT_NEAR(shift.y(), 0.0, 1e-9);
  const HandSkin now = track.skin_at(track.seen_s);
  const HandSkin later = track.skin_at(track.seen_s + 0.1);
  ASSERT_FALSE(now.empty());
  EXPECT_LT((later[0].from - now[0].from - shift).norm(), 1e-9);
}

TEST(HandTrack, ALeapIsNotTakenForASpeed) {
  HandTrack track(1, 0.0, {});
  track.move_to(pose_at(0.0), 0.0);
  track.move_to(pose_at(1000.0), 0.03);
  EXPECT_GT(track.velocity.norm(), 0.0);
  EXPECT_LT(track.velocity.norm(), 4000.0);
}

TEST(HandTrack, ALeftHandMovesInTheMirror) {
  HandTrack track(1, 0.0, {});
  EXPECT_TRUE(track.agree_on_side(HandSide::left, 0.0));
  track.move_to(pose_at(100.0), 0.0);
  track.move_to(pose_at(110.0), 0.1);
  EXPECT_LT(track.velocity.x(), 0.0);
  HandTrack right(2, 0.0, {});
  right.move_to(pose_at(110.0), 0.0);
  EXPECT_EQ(track.middle.y(), right.middle.y());
  EXPECT_EQ(track.middle.x(), -right.middle.x());
}

TEST(HandTrack, TakenBackItIsWhatItWasBeforeItsLastMove) {
  HandTrack track(1, 0.0, {});
  // As the tracker does: it moves, then learns from that.
  const auto move = [&](double x_mm, double size, double now_s) {
    SkeletonPose pose = pose_at(x_mm);
    pose.size = size;
    track.move_to(pose, now_s);
    track.person.learn(pose);
    track.agreed_s = now_s;
    track.agreed_turn = Eigen::AngleAxisd(now_s, Eigen::Vector3d::UnitX()).toRotationMatrix();
  };
  const auto size_of = [](const PersonHand& person) {
    SkeletonFitOptions options;
    person.tell(options);
    return options.size;
  };
  move(0.0, 1.1, 0.1);
  move(10.0, 1.1, 0.2);
  EXPECT_NEAR(track.leapt_mm, 10.0, 1e-9);
  const Point3 middle = track.middle;
  const Eigen::Matrix3d turn = track.agreed_turn;
  move(100.0, 1.3, 0.3);
  EXPECT_GT(track.leapt_mm, 70.0);
  track.take_back();
  EXPECT_FALSE(track.is_seen_at(0.3));
  EXPECT_EQ(track.seen_s, 0.2);
  EXPECT_EQ(track.agreed_s, 0.2);
  EXPECT_EQ(track.agreed_turn, turn);
  EXPECT_EQ(track.middle, middle);
  EXPECT_EQ(track.pose->camera_from_hand.translation().x(), 10.0);
  EXPECT_EQ(track.velocity, Eigen::Vector3d::Zero());
  EXPECT_NEAR(size_of(track.person), 1.1, 1e-12);
}

TEST(HandTrack, TheForearmGoesOnBehindTheWrist) {
  HandTrack track(1, 0.0, {});
  EXPECT_TRUE(track.skin_at(0.0).empty()) << "it was never fitted";
  track.move_to(pose_at(0.0), 0.0);
  const HandCapsule arm = track.forearm().at(0);
  EXPECT_GT((arm.to - track.middle).norm(), (arm.from - track.middle).norm());
  EXPECT_GT((arm.to - arm.from).norm(), 150.0);
}

}  // namespace
}  // namespace knuckle
