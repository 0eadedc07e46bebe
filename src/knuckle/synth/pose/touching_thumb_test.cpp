// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/touching_thumb.h"

#include <cmath>

#include "knuckle/core/angle.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/synth/pose/gestures.h"

namespace knuckle {
namespace {

double between_mm(const HandAngles& hand, Landmark a, Landmark b) {
  const auto points = landmarks(adult_skeleton(), hand, RigidTransform::Identity());
  return (points[static_cast<std::size_t>(a)] - points[static_cast<std::size_t>(b)]).norm();
}

TEST(TouchingThumb, TheTipComesToTheTipOfEachFinger) {
  constexpr Landmark kTips[] = {Landmark::index_tip, Landmark::middle_tip, Landmark::ring_tip,
                                Landmark::little_tip};
  for (int finger = 0; finger < 4; ++finger) {
    HandAngles hand = gesture_from_name("ok").angles;
    const FingerAngleNames names = angles_of_finger(finger);
    hand[names.mcp] = 50 * kDegree;
    hand[names.pip] = 60 * kDegree;
    hand[names.dip] = 30 * kDegree;
    const ThumbContact contact{.finger = finger, .bone = 2, .along = 1.0, .distance_mm = 14.0};
    const HandAngles touching = with_touching_thumb(hand, contact);
    EXPECT_NEAR(between_mm(touching, Landmark::thumb_tip, kTips[finger]), 14.0, finger == 3 ? 6.0 : 1.5)
        << finger;
    EXPECT_NEAR(distance_from_contact_mm(touching, contact),
                std::abs(between_mm(touching, Landmark::thumb_tip, kTips[finger]) - 14.0), 1e-9);
    EXPECT_GT(between_mm(hand, Landmark::thumb_tip, kTips[finger]), finger == 0 ? 0.0 : 25.0);
    EXPECT_TRUE(within_limits(touching));
  }
}

TEST(TouchingThumb, OnlyTheThumbMoves) {
  const HandAngles hand = clamped(gesture_from_name("four").angles);
  const HandAngles touching = with_touching_thumb(hand, {.finger = 2, .bone = 1});
  EXPECT_NE(touching[HandAngle::thumb_palmar], hand[HandAngle::thumb_palmar]);
  for (int i = 5; i < kHandAngleCount; ++i) EXPECT_EQ(touching.radians[i], hand.radians[i]) << i;
}

TEST(TouchingThumb, NoOtherThumbIsBetter) {
  const HandAngles hand = clamped(gesture_from_name("ok").angles);
  const ThumbContact contact{.finger = 0, .bone = 2, .along = 0.5, .distance_mm = 25.0};
  const auto cost = [&](const HandAngles& candidate) {
    constexpr double kDeviations[] = {22 * kDegree, 22 * kDegree, 14 * kDegree, 18 * kDegree, 7 * kDegree};
    double sum = std::pow(distance_from_contact_mm(candidate, contact), 2);
    for (int i = 0; i < 5; ++i) sum += std::pow((candidate.radians[i] - hand.radians[i]) / kDeviations[i], 2);
    return sum;
  };
  const HandAngles best = with_touching_thumb(hand, contact);
  for (int i = 0; i < 5; ++i) {
    for (const double step : {-2 * kDegree, 2 * kDegree}) {
      HandAngles other = best;
      other.radians[i] += step;
      if (within_limits(other)) {
        EXPECT_GT(cost(other), cost(best)) << i << ' ' << step;
      }
    }
  }
}

/// An angle's share of the way is in proportion to the square of its deviation.
TEST(TouchingThumb, TheEndJointKeepsItsBend) {
  const HandAngles hand = clamped(gesture_from_name("ok").angles);
  const HandAngles touching =
      with_touching_thumb(hand, {.finger = 0, .bone = 2, .along = 0.5, .distance_mm = 40.0});
  const auto moved = [&](HandAngle angle) { return std::abs(touching[angle] - hand[angle]); };
  EXPECT_GT(moved(HandAngle::thumb_mcp), 2 * kDegree);
  EXPECT_LT(moved(HandAngle::thumb_ip), 0.4 * moved(HandAngle::thumb_mcp));
}

TEST(TouchingThumb, AFingerOutOfReachIsApproached) {
  const HandAngles hand = clamped(gesture_from_name("spread").angles);  // its little finger stands off
  const ThumbContact contact{.finger = 3, .bone = 2, .along = 1.0, .distance_mm = 12.0};
  const HandAngles nearer = with_touching_thumb(hand, contact);
  EXPECT_TRUE(within_limits(nearer));
  EXPECT_LT(distance_from_contact_mm(nearer, contact), distance_from_contact_mm(hand, contact));
  EXPECT_GT(distance_from_contact_mm(nearer, contact), 20.0);
}

}  // namespace
}  // namespace knuckle
