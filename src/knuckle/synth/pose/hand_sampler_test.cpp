// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/hand_sampler.h"

#include <algorithm>

#include "knuckle/core/testing.h"
#include "knuckle/synth/pose/gestures.h"
#include "knuckle/synth/pose/touching_thumb.h"

namespace knuckle {
namespace {

TEST(HandSampler, EverySampleKeepsToTheLimits) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const HandAngles hand = sampled_hand({}, random);
    EXPECT_EQ(clamped(hand), hand);
  }
}

TEST(HandSampler, ReachesBothEndsOfEveryJoint) {
  Random random(4);
  HandAngles low = sampled_hand({}, random);
  HandAngles high = low;
  for (int i = 0; i < 5000; ++i) {
    const HandAngles hand = sampled_hand({}, random);
    for (int k = 0; k < kHandAngleCount; ++k) {
      low.radians[k] = std::min(low.radians[k], hand.radians[k]);
      high.radians[k] = std::max(high.radians[k], hand.radians[k]);
    }
  }
  for (int k = 0; k < kHandAngleCount; ++k) {
    const AngleRange range = range_of(static_cast<HandAngle>(k));
    EXPECT_GT(high.radians[k] - low.radians[k], 0.8 * (range.high - range.low)) << k;
  }
}

TEST(HandSampler, AKindWithoutAShareIsNotDrawn) {
  Random random(5);
  const HandPoseOptions gestures_only{.pair_share = 0,
                                      .mixed_share = 0,
                                      .closing_share = 0,
                                      .grasp_share = 0,
                                      .uniform_share = 0,
                                      .jitter_deg = 0};
  for (int i = 0; i < 200; ++i) {
    const HandAngles hand = sampled_hand(gestures_only, random);
    EXPECT_TRUE(std::ranges::any_of(gestures(),
                                    [&](const Gesture& gesture) { return clamped(gesture.angles) == hand; }));
  }
}

TEST(HandSampler, DrawsOnlyTheGesturesThatAreLeft) {
  HandPoseOptions options{.pair_share = 0,
                          .mixed_share = 0,
                          .closing_share = 0,
                          .grasp_share = 0,
                          .uniform_share = 0,
                          .jitter_deg = 0};
  options.gestures = {"rock", "ok", "four"};
  options.without_gestures = {"ok"};
  EXPECT_EQ(allowed_gestures(options), (std::vector<std::string_view>{"four", "rock"}));
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    const HandAngles hand = sampled_hand(options, random);
    EXPECT_TRUE(hand == clamped(gesture_from_name("rock").angles) ||
                hand == clamped(gesture_from_name("four").angles));
  }
}

TEST(HandSampler, AThumbThatTouchesDoesSoInMostHands) {
  const HandPoseOptions touching_only{.gesture_share = 0,
                                      .pair_share = 0,
                                      .mixed_share = 0,
                                      .closing_share = 0,
                                      .grasp_share = 0,
                                      .uniform_share = 0,
                                      .touch_share = 1};
  Random random(7);
  int touching = 0;
  int with_index = 0;
  for (int i = 0; i < 400; ++i) {
    const HandAngles hand = sampled_hand(touching_only, random);
    EXPECT_TRUE(within_limits(hand));
    bool is_touching = false;
    for (int finger = 0; finger < 4; ++finger) {
      for (const int bone : {1, 2}) {
        for (const double along : {0.1, 0.5, 0.9}) {
          const double off = distance_from_contact_mm(hand, {finger, bone, along, 15.0});
          is_touching = is_touching || off < 6.0;
          if (finger == 0 && bone == 2 && along == 0.9) with_index += off < 8.0;
        }
      }
    }
    touching += is_touching;
  }
  EXPECT_GT(touching, 340);
  EXPECT_GT(with_index, 100);
  EXPECT_LT(with_index, 300);
}

TEST(HandSampler, RefusesGesturesThatLeaveNone) {
  HandPoseOptions options;
  options.gestures = {"rock"};
  EXPECT_THAT(testing::error_of([&] { check(options, "here"); }), ::testing::HasSubstr("closing_share"));
  options.closing_share = 0;
  EXPECT_NO_THROW(check(options, "here"));
  options.touch_share = 0.1;
  EXPECT_THAT(testing::error_of([&] { check(options, "here"); }), ::testing::HasSubstr("touch_share is 0.1"));
  options.touch_share = 0;
  options.without_gestures = {"rock"};
  EXPECT_THAT(testing::error_of([&] { check(options, "here"); }), ::testing::HasSubstr("without_gestures"));
  options.gestures = {"wave"};
  EXPECT_THAT(testing::error_of([&] { check(options, "here"); }), ::testing::HasSubstr("wave"));
}

TEST(HandSampler, RefusesNoKindAtAll) {
  const HandPoseOptions none{.gesture_share = 0,
                             .pair_share = 0,
                             .mixed_share = 0,
                             .closing_share = 0,
                             .grasp_share = 0,
                             .uniform_share = 0};
  EXPECT_THAT(testing::error_of([&] { check(none, "here"); }),
              ::testing::HasSubstr("here: all of gesture_share"));
  HandPoseOptions shaky;
  shaky.jitter_deg = 90;
  EXPECT_THAT(testing::error_of([&] { check(shaky, "here"); }), ::testing::HasSubstr("jitter_deg"));
}

}  // namespace
}  // namespace knuckle
