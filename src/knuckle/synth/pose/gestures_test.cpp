// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/gestures.h"

#include <map>
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

TEST(Gestures, StretchTheFingersOfTheirNames) {
  // Index, middle, ring, little; those not named are bent.
  const std::map<std::string_view, std::string_view> stretched = {{"open", "imrl"},
                                                                  {"fist", ""},
                                                                  {"thumb_up", ""},
                                                                  {"point", "i"},
                                                                  {"gun", "i"},
                                                                  {"peace", "im"},
                                                                  {"three", "imr"},
                                                                  {"four", "imrl"},
                                                                  {"little_up", "l"},
                                                                  {"middle_up", "m"},
                                                                  {"rock", "il"},
                                                                  {"love_you", "il"},
                                                                  {"call_me", "l"},
                                                                  {"two_thumb", "im"},
                                                                  {"three_thumb", "im"},
                                                                  {"six_thumb_little", "imr"},
                                                                  {"seven_thumb_ring", "iml"},
                                                                  {"eight_thumb_middle", "irl"}};
  for (const auto& [name, letters] : stretched) {
    const HandAngles& angles = gesture_from_name(name).angles;
    for (int finger = 0; finger < 4; ++finger) {
      const bool is_stretched = letters.find("imrl"[finger]) != std::string_view::npos;
      const double bend = angles[angles_of_finger(finger).mcp] + angles[angles_of_finger(finger).pip];
      EXPECT_EQ(bend < 0.3, is_stretched) << name << ", finger " << finger << ": " << bend;
      EXPECT_EQ(bend > 1.5, !is_stretched) << name << ", finger " << finger << ": " << bend;
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
