// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_angles.h"

#include <string_view>
#include <vector>

#include "knuckle/core/angle.h"
#include "knuckle/core/pose.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/hand_bones.h"
#include "knuckle/hand/landmark_points.h"
#include "knuckle/hand/skeleton_testing.h"

namespace knuckle {
namespace {

HandLimits narrow_limits() {
  HandLimits limits;
  for (AngleRange& range : limits.ranges) range = {-0.1, 0.3};
  limits.dip_below_coupling = 0.05;
  limits.dip_above_coupling = 0.05;
  limits.spread_left_when_bent = 0.5;
  return limits;
}

TEST(HandAnglesTest, ClampingLeavesWhatIsWithinAndDoesNothingTwice) {
  Random random(1);
  for (const HandLimits& limits : {healthy_limits(), narrow_limits()}) {
    for (int trial = 0; trial < 100; ++trial) {
      HandAngles wild;
      for (double& angle : wild.radians) angle = random.uniform(-3.0, 3.0);
      const HandAngles hand = clamped(wild, limits);
      EXPECT_TRUE(within_limits(hand, limits));
      EXPECT_EQ(clamped(hand, limits), hand);
      for (int i = 0; i < kHandAngleCount; ++i) {
        EXPECT_GE(hand.radians[i], limits.ranges[i].low);
        EXPECT_LE(hand.radians[i], limits.ranges[i].high);
      }
    }
  }
}

TEST(HandAnglesTest, LimitsAreThoseThatAreGiven) {
  HandAngles angles;
  angles[HandAngle::index_mcp] = 0.5;
  EXPECT_TRUE(within_limits(angles));
  EXPECT_FALSE(within_limits(angles, narrow_limits()));
  EXPECT_DOUBLE_EQ(clamped(angles, narrow_limits())[HandAngle::index_mcp], 0.3);
  angles = {};
  angles[HandAngle::ring_pip] = 0.3;
  EXPECT_DOUBLE_EQ(clamped(angles, narrow_limits())[HandAngle::ring_dip], coupled_dip(0.3) - 0.05);
  HandLimits wide = narrow_limits();
  wide.ranges[static_cast<int>(HandAngle::ring_dip)].high = 1.5;
  angles[HandAngle::ring_dip] = 1.0;
  EXPECT_DOUBLE_EQ(clamped(angles, wide)[HandAngle::ring_dip], coupled_dip(0.3) + 0.05);
}

TEST(HandAnglesTest, WhatIsNotANumberIsNotWithin) {
  for (int i = 0; i < kHandAngleCount; ++i) {
    HandAngles angles;
    angles.radians[i] = kNaN;
    EXPECT_FALSE(within_limits(angles)) << i;
  }
}

TEST(HandAnglesTest, ABentFingerSpreadsLess) {
  HandAngles angles;
  angles[HandAngle::index_spread] = 1.0;
  angles[HandAngle::index_mcp] = 90.0 * kDegree;
  EXPECT_DOUBLE_EQ(clamped(angles)[HandAngle::index_spread], 0.25 * range_of(HandAngle::index_spread).high);
}

TEST(HandAnglesTest, NamesAreThoseOfTheJoints) {
  const std::vector<std::string_view> expected{
      "thumb_radial",  "thumb_palmar", "thumb_twist", "thumb_mcp",  "thumb_ip",      "index_mcp",
      "index_spread",  "index_pip",    "index_dip",   "middle_mcp", "middle_spread", "middle_pip",
      "middle_dip",    "ring_mcp",     "ring_spread", "ring_pip",   "ring_dip",      "little_mcp",
      "little_spread", "little_pip",   "little_dip",  "palm_arch"};
  std::vector<std::string_view> names;
  for (int i = 0; i < kHandAngleCount; ++i) names.push_back(name_of(static_cast<HandAngle>(i)));
  EXPECT_EQ(names, expected);
  EXPECT_EQ(name_of(HandAngle::middle_dip), "middle_dip");
  EXPECT_EQ(name_of(HandAngle::ring_mcp), "ring_mcp");
  EXPECT_EQ(name_of(HandAngle::palm_arch), "palm_arch");
}

TEST(LandmarkPointsTest, EachLandmarkLiesOnTheBoneBeyondIt) {
  EXPECT_EQ(carrier_of(Landmark::wrist), HandBone::palm);
  EXPECT_EQ(carrier_of(Landmark::palm), HandBone::palm);
  EXPECT_EQ(carrier_of(Landmark::thumb_cmc), HandBone::thumb_metacarpal);
  EXPECT_EQ(carrier_of(Landmark::index_pip), HandBone::index_middle);
  EXPECT_EQ(carrier_of(Landmark::little_dip), HandBone::little_distal);
  EXPECT_EQ(carrier_of(Landmark::little_tip), HandBone::little_distal);
  EXPECT_EQ(name_of(carrier_of(Landmark::ring_mcp)), "ring_proximal");
  EXPECT_THAT(testing::error_of([] { carrier_of(Landmark::nyu_wrist_1); }),
              ::testing::HasSubstr("'nyu_wrist_1' belongs to one data set"));
}

}  // namespace
}  // namespace knuckle
