// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/gestures.h"

#include <set>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(Gestures, AreManyAndEachHasItsOwnName) {
  std::set<std::string_view> names;
  for (const Gesture& gesture : gestures()) names.insert(gesture.name);
  EXPECT_GE(names.size(), 40u);
  EXPECT_EQ(names.size(), gestures().size());
}

TEST(Gestures, KeepToTheLimitsOfTheJoints) {
  for (const Gesture& gesture : gestures()) {
    const HandAngles limited = clamped(gesture.angles);
    for (int i = 0; i < kHandAngleCount; ++i) {
      EXPECT_NEAR(limited.radians[i], gesture.angles.radians[i], 0.2) << gesture.name << ", angle " << i;
    }
  }
}

TEST(Gestures, AreFoundByName) {
  EXPECT_EQ(gesture_from_name("fist").name, "fist");
  const std::string message = testing::error_of([] { gesture_from_name("fits"); });
  EXPECT_THAT(message, ::testing::HasSubstr("'fits'"));
  EXPECT_THAT(message, ::testing::HasSubstr("peace"));
}

TEST(HandAngles, LimitsAreKeptAndLeaveTheLimitedAlone) {
  HandAngles wild;
  for (int i = 0; i < kHandAngleCount; ++i) wild.radians[i] = i % 2 == 0 ? 7.0 : -7.0;
  const HandAngles limited = clamped(wild);
  for (int i = 0; i < kHandAngleCount; ++i) {
    const AngleRange range = range_of(static_cast<HandAngle>(i));
    EXPECT_GE(limited.radians[i], range.low - 1e-12);
    EXPECT_LE(limited.radians[i], range.high + 1e-12);
  }
  EXPECT_EQ(clamped(limited), limited);
  EXPECT_EQ(clamped(HandAngles{}), HandAngles{});
}

TEST(HandAngles, ABentFingerSpreadsLess) {
  HandAngles angles;
  angles[HandAngle::index_spread] = 0.4;
  EXPECT_DOUBLE_EQ(clamped(angles)[HandAngle::index_spread], 0.4);
  angles[HandAngle::index_mcp] = 1.5;
  EXPECT_LT(clamped(angles)[HandAngle::index_spread], 0.2);
}

TEST(HandAngles, TheDipFollowsThePip) {
  HandAngles angles;
  angles[HandAngle::ring_pip] = 1.8;
  EXPECT_GT(clamped(angles)[HandAngle::ring_dip], 0.3);
  angles[HandAngle::ring_pip] = 0.0;
  angles[HandAngle::ring_dip] = 1.3;
  EXPECT_LT(clamped(angles)[HandAngle::ring_dip], 0.4);
}

TEST(HandAngles, InterpolateFromOneToTheOther) {
  const HandAngles& fist = gesture_from_name("fist").angles;
  const HandAngles& open = gesture_from_name("open").angles;
  EXPECT_EQ(interpolated(fist, open, 0.0), fist);
  EXPECT_EQ(interpolated(fist, open, 1.0), open);
  const HandAngles half = interpolated(fist, open, 0.5);
  EXPECT_NEAR(half[HandAngle::index_pip], 0.5 * (fist[HandAngle::index_pip] + open[HandAngle::index_pip]),
              1e-12);
}

}  // namespace
}  // namespace knuckle
