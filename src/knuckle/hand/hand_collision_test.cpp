// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_collision.h"

#include <Eigen/Geometry>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

/// A flat open hand: fingers 20 mm apart along y, thumb aside.
std::array<Point3, kSupersetSize> open_hand() {
  std::array<Point3, kSupersetSize> points;
  points[0] = {0, 0, 0};
  points[1] = {0, 50, 0};
  for (int part = 0; part < 4; ++part) {
    points[2 + part] = {30.0 + 20.0 * part, 20.0 + 15.0 * part, 0};
    for (int finger = 0; finger < 4; ++finger) {
      points[6 + 4 * finger + part] = {30.0 - 20.0 * finger, 95.0 + 25.0 * part, 0};
    }
  }
  return points;
}

TEST(HandCollision, AnOpenHandIsFree) {
  EXPECT_EQ(worst_penetration_mm(open_hand()), 0.0);
}

TEST(HandCollision, CrossedFingersTouch) {
  auto points = open_hand();
  const auto index_tip = static_cast<std::size_t>(Landmark::index_tip);
  const auto middle_tip = static_cast<std::size_t>(Landmark::middle_tip);
  std::swap(points[index_tip], points[middle_tip]);
  EXPECT_GT(worst_penetration_mm(points), 10.0);
}

TEST(HandCollision, AThumbMayLieAtThePalmButNotInIt) {
  auto points = open_hand();
  const auto thumb = [&](Landmark landmark) -> Point3& { return points[static_cast<std::size_t>(landmark)]; };
  // Its middle phalanx crosses the palm, its last one ends behind it; where the thumb begins is part of the
  // palm.
  thumb(Landmark::thumb_cmc) = {25, 10, 30};
  thumb(Landmark::thumb_mcp) = {60, 40, 20};
  thumb(Landmark::thumb_ip) = {-15, 60, 0};
  thumb(Landmark::thumb_tip) = {-60, 60, 40};
  const double both = worst_penetration_mm(points);
  EXPECT_GT(both, 10.0);
  // The middle phalanx alone goes through the palm.
  thumb(Landmark::thumb_cmc) = {30, 20, 60};
  thumb(Landmark::thumb_mcp) = {0, 60, 40};
  thumb(Landmark::thumb_ip) = {0, 60, -40};
  thumb(Landmark::thumb_tip) = {0, 60, -80};
  EXPECT_GT(worst_penetration_mm(points), 10.0);
  thumb(Landmark::thumb_cmc) = {25, 10, 30};
  thumb(Landmark::thumb_ip) = {60, 60, 40};
  thumb(Landmark::thumb_tip) = {60, 80, 50};
  EXPECT_EQ(worst_penetration_mm(points), 0.0);
  thumb(Landmark::thumb_cmc) = {5, 30, 0};
  thumb(Landmark::thumb_mcp) = {60, 40, 30};
  EXPECT_EQ(worst_penetration_mm(points), 0.0);
}

TEST(HandCollision, TheDepthIsThatOfTwoCapsules) {
  auto points = open_hand();
  const auto tip = static_cast<std::size_t>(Landmark::index_tip);
  points[tip - 1] = {18, 145, 0};  // the index finger's end beside the middle finger's, 8 mm off
  points[tip] = {18, 170, 0};
  const double radius = 0.078 * (points[static_cast<std::size_t>(Landmark::middle_mcp)] - points[0]).norm();
  EXPECT_NEAR(worst_penetration_mm(points), 2.0 * radius - 8.0, 0.01);
}

TEST(HandCollision, DoesNotDependOnTheView) {
  auto points = open_hand();
  points[static_cast<std::size_t>(Landmark::thumb_tip)] = {20, 100, 0};
  const double before = worst_penetration_mm(points);
  EXPECT_GT(before, 1.0);
  const Eigen::AngleAxisd turn(1.1, Eigen::Vector3d(1, 2, 3).normalized());
  for (Point3& point : points) point = turn * point + Point3(5, 6, 700);
  EXPECT_NEAR(worst_penetration_mm(points), before, 1e-9);
}

TEST(HandCapsules, GapsAreDistancesLessTheFlesh) {
  const HandCapsule a{{0, 0, 0}, {100, 0, 0}, 10, 1, 0};
  EXPECT_NEAR(gap_mm(a, {{50, 30, -40}, {50, 30, 40}, 5, 1, 0}), 15.0, 1e-9);
  EXPECT_NEAR(gap_mm(a, {{103, 4, 0}, {200, 90, 0}, 2, 1, 0}), -7.0, 1e-9);
}

TEST(HandCapsules, HandsApartHaveTheGapOfTheirNearestBones) {
  const auto hand = open_hand();
  const auto capsules = hand_capsules(hand);
  EXPECT_EQ(capsules.size(), 19u);
  auto moved = hand;
  for (Point3& landmark : moved) landmark.z() += 300.0;
  double least = 1e9;  // by brute force over points of the bones
  for (const HandCapsule& a : capsules) {
    for (const HandCapsule& b : hand_capsules(moved)) {
      for (int i = 0; i <= 20; ++i) {
        for (int k = 0; k <= 20; ++k) {
          const Point3 p = a.from + 0.05 * i * (a.to - a.from);
          const Point3 q = b.from + 0.05 * k * (b.to - b.from);
          least = std::min(least, (p - q).norm() - a.radius - b.radius);
        }
      }
    }
  }
  EXPECT_NEAR(gap_of_hands_mm(capsules, hand_capsules(moved)), least, 0.5);
}

}  // namespace
}  // namespace knuckle
