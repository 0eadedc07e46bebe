// SPDX-License-Identifier: Apache-2.0
// One hand that is followed, and what the tracker refuses.
#include <numbers>
#include <thread>

#include "knuckle/track/tracker_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::kDepthMm;
using testing::symmetric_camera;
using testing::TrackerTest;
using testing::TrueHand;

TEST_F(TrackerTest, AHandThatMovesKeepsItsIdAndIsFoundWithoutASearch) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {.smoothing = "none", .search_every_s = 0.5});
  world_.hands = {{}};
  for (int i = 0; i < 40; ++i) {
    world_.hands[0].middle.x() = -150.0 + 7.5 * i;
    const auto hands = tracker.update(frame_at(i / 30.0));
    ASSERT_EQ(hands.size(), 1u) << i;
    EXPECT_EQ(hands[0].id, 1);
    EXPECT_EQ(hands[0].side, HandSide::right);
    EXPECT_LT((middle_of(hands[0]) - world_.hands[0].middle).norm(), 3.0) << i;
    EXPECT_LT(hands[0].score, 0.9) << "a hand before a wall that is as near is not quite plausible";
    EXPECT_GT(hands[0].score, 0.5);
  }
  EXPECT_LE(world_.searches, 7) << "until it is trusted";
}

TEST_F(TrackerTest, WhatIsFollowedGivesItsPlaceToWhatTheWholeFrameShows) {
  const TrueHand thing{{-120, 0, kDepthMm}};
  const TrueHand hand{{120, 0, kDepthMm}};
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {.search_every_s = 0.3});
  world_.hands = {thing};
  for (int i = 0; i < 3; ++i) EXPECT_EQ(tracker.update(frame_at(i / 30.0)).at(0).id, 1);
  world_.hands = {hand, thing};  // the thing is still there to be followed
  int id = 1;
  for (int i = 3; i < 30 && id == 1; ++i) {
    const TrackedHand found = tracker.update(frame_at(i / 30.0)).at(0);
    id = found.id;
    if (id == 2) {
      EXPECT_LT((middle_of(found) - hand.middle).norm(), 10.0);
    }
  }
  EXPECT_EQ(id, 2);
}

TEST_F(TrackerTest, OneSearchThatErrsDoesNotLoseATrustedHand) {
  const TrueHand hand{{-120, 0, kDepthMm}};
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {.search_every_s = 0.2});
  for (int i = 0; i < 120; ++i) {
    world_.hands = {hand};
    if (i >= 60 && i < 67) world_.hands = {{{120, 0, kDepthMm}}, hand};
    EXPECT_EQ(tracker.update(frame_at(i / 30.0)).at(0).id, 1) << i;
  }
}

TEST_F(TrackerTest, ALostHandIsForgottenAndOneThatReturnsIsSeenAtOnce) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {});
  int id = 0;
  for (int i = 0; i < 100; ++i) {
    const bool is_there = i % 20 < 10;
    world_.hands = is_there ? std::vector<TrueHand>{{{i % 40 < 20 ? -100.0 : 100.0, 0, kDepthMm}}}
                            : std::vector<TrueHand>{};
    const auto hands = tracker.update(frame_at(i / 30.0));
    EXPECT_EQ(hands.size(), is_there ? 1u : 0u) << i;
    if (!hands.empty()) {
      EXPECT_GE(hands[0].id, id);
      id = hands[0].id;
    }
  }
  EXPECT_EQ(id, 5) << "each time another one";
}

TEST_F(TrackerTest, AHandThatIsUnsureForAMomentKeepsItsId) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {});
  world_.hands = {{}};
  for (int i = 0; i < 12; ++i) {
    world_.hands[0].confidence = i == 5 || i == 6 ? 0.2f : 0.9f;
    const auto hands = tracker.update(frame_at(i / 30.0));
    ASSERT_EQ(hands.size(), i == 5 || i == 6 ? 0u : 1u) << i;
    if (!hands.empty()) {
      EXPECT_EQ(hands[0].id, 1);
    }
  }
}

TEST_F(TrackerTest, WhatComesUpFarFromWhereAHandWasLostIsAnotherHand) {
  const Pipeline one = pipeline(1);
  for (const double distance : {250.0, 400.0}) {
    Tracker tracker(one, {.lost_after_s = 1.0});
    for (int i = 0; i < 10; ++i) {
      world_.hands = {{{-200, 0, kDepthMm}}};
      if (i == 7) world_.hands.clear();
      if (i > 7) world_.hands[0].middle.x() += distance;
      const auto hands = tracker.update(frame_at(i / 30.0));
      ASSERT_EQ(hands.size(), i == 7 ? 0u : 1u) << distance << ", " << i;
      if (i > 7) {
        EXPECT_EQ(hands[0].id, distance < 300.0 ? 1 : 2) << distance;
      }
    }
  }
}

TEST_F(TrackerTest, ConfidencesAreCalibratedWhereTheyComeOutAndTheFitDoesWithoutThat) {
  const Pipeline plain = pipeline(1);
  const Pipeline calibrated = pipeline(1, -1.5);
  Tracker one(plain, {});
  Tracker other(calibrated, {});
  world_.hands = {{}};
  world_.hands[0].confidence = 0.8f;
  for (int i = 0; i < 3; ++i) {
    const auto before = one.update(frame_at(i / 30.0));
    const auto after = other.update(frame_at(i / 30.0));
    ASSERT_EQ(before.size(), 1u);
    ASSERT_EQ(after.size(), 1u) << "0.8 is sure, 0.47 would hardly be";
    EXPECT_FLOAT_EQ(before[0].pose.confidence[5], 0.8f);
    EXPECT_NEAR(after[0].pose.confidence[5], 1.0 / (1.0 + std::exp(1.5) / 4.0), 1e-6);
    EXPECT_EQ(after[0].angles.radians, before[0].angles.radians);
    EXPECT_EQ(after[0].score, before[0].score);
  }
}

TEST_F(TrackerTest, BonesKeepTheirLengthOnceThePersonIsKnown) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {.learn_s = 0.5});
  world_.hands = {{}};
  world_.noise_mm = 3.0;
  world_.size = 1.12;
  double size = 0.0;
  for (int i = 0; i < 60; ++i) {
    const auto hands = tracker.update(frame_at(i / 30.0));
    ASSERT_EQ(hands.size(), 1u);
    if (i == 20) size = hands[0].size;
    if (i > 20) {
      EXPECT_EQ(hands[0].size, size);
    }
  }
  EXPECT_NEAR(size, 1.12, 0.03);
}

TEST_F(TrackerTest, SmoothingTakesTheTremblingAndStrengthSaysHowMuch) {
  const auto trembling = [&](const TrackerOptions& options, double noise_mm = 1.0) {
    const Pipeline one = pipeline(1);
    Tracker tracker(one, options);
    world_ = {.hands = {{}}, .noise_mm = noise_mm};
    Point3 last = Point3::Zero();
    double sum = 0.0;
    for (int i = 0; i < 90; ++i) {
      const auto hands = tracker.update(frame_at(i / 30.0));
      const Point3 tip =
          Projection(symmetric_camera())
              .to_camera(hands.at(0).pose.joints[static_cast<std::size_t>(Landmark::index_tip)]);
      if (i > 30) sum += (tip - last).norm();
      last = tip;
    }
    return sum / 59;
  };
  const double raw = trembling({.smoothing = "none"});
  const double weak = trembling({.strength = 0.5});
  const double strong = trembling({.strength = 2.0});
  EXPECT_LT(weak, 0.9 * raw);
  EXPECT_LT(strong, 0.7 * weak);
  // So little noise is no motion: what is taken of it at rest decides.
  EXPECT_LT(trembling({.smoothing = "one_euro", .strength = 4.0}, 0.05),
            0.7 * trembling({.smoothing = "one_euro"}, 0.05));
}

TEST_F(TrackerTest, TimeThatDoesNotGoOnBeginsANewTrack) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {});
  world_.hands = {{}};
  EXPECT_EQ(tracker.update(frame_at(10.0)).at(0).id, 1);
  EXPECT_EQ(tracker.update(frame_at(10.03)).at(0).id, 1);
  EXPECT_EQ(tracker.update(frame_at(10.03)).at(0).id, 2) << "stands still";
  EXPECT_EQ(tracker.update(frame_at(9.0)).at(0).id, 3) << "goes back";
  EXPECT_EQ(tracker.update(frame_at(9.03)).at(0).id, 3);
  EXPECT_EQ(tracker.update(frame_at(10.1)).at(0).id, 4) << "leaps";
  EXPECT_EQ(tracker.update(frame_at(3609.0)).at(0).id, 5);
  Frame other = frame_at(3609.03);
  other.sequence = 1;
  EXPECT_EQ(tracker.update(other).at(0).id, 6) << "another sequence";
  Frame untimed = frame_at(std::nan(""));
  untimed.name = "000012";
  EXPECT_THAT(error_of([&] { tracker.update(untimed); }),
              HasSubstr("tracker: frame 000012 has a time that is not finite"));
  untimed.name = "";
  EXPECT_THAT(error_of([&] { tracker.update(untimed); }), HasSubstr("tracker: a frame has a time"));
  tracker.reset();
  EXPECT_EQ(tracker.update(frame_at(1.0)).at(0).id, 1);
  Frame timeless = frame_at(0.0);
  timeless.time_s.reset();
  tracker.reset();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(tracker.update(timeless).at(0).id, 1);
}

TEST_F(TrackerTest, AHandThatTurnsOutToBeTheOtherOneBeginsAfresh) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {});
  world_.hands = {{{100, 0, kDepthMm}, HandSide::left}};
  EXPECT_EQ(tracker.update(frame_at(0.0)).at(0).side, HandSide::left);
  world_.hands[0].side = HandSide::right;
  const TrackedHand found = tracker.update(frame_at(0.03)).at(0);
  EXPECT_EQ(found.side, HandSide::right);
  Tracker fresh(one, {});
  const TrackedHand expected = fresh.update(frame_at(0.03)).at(0);
  EXPECT_LT((found.camera_from_hand.matrix() - expected.camera_from_hand.matrix()).norm(), 1e-6)
      << "nothing of the mirrored hand is left";
  EXPECT_EQ(found.angles, expected.angles);
}

TEST_F(TrackerTest, AHandWhoseSideIsMistakenForAMomentIsStillSeen) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {});
  world_.hands = {{{100, 0, kDepthMm}, HandSide::left}};
  for (int i = 0; i < 12; ++i) {
    world_.hands[0].side = i % 4 == 3 ? HandSide::right : HandSide::left;
    const std::vector<TrackedHand> hands = tracker.update(frame_at(i / 30.0));
    ASSERT_EQ(hands.size(), 1u) << i;
    EXPECT_EQ(hands[0].id, 1);
    EXPECT_EQ(hands[0].side, HandSide::left);
    EXPECT_LT((middle_of(hands[0]) - world_.hands[0].middle).norm(), 10.0) << i;
  }
}

TEST_F(TrackerTest, AHandIsNotTurnedAboutInAMoment) {
  const Pipeline seeing = pipeline(1);
  Tracker tracker(seeing, {.smoothing = "none"});
  world_.hands = {TrueHand{}};
  const auto wrist_at = [&](int frame) {
    const auto hands = tracker.update(frame_at(frame / 30.0));
    EXPECT_EQ(hands.size(), 1u) << frame;
    return hands.empty() ? Point3(0, 0, 0)
                         : Projection(symmetric_camera()).to_camera(hands[0].pose.joints[0]);
  };
  const Point3 upright = wrist_at(0);
  world_.turned_rad = 0.5;  // as fast as hands turn
  const Point3 aside = wrist_at(1);
  EXPECT_GT((aside - upright).norm(), 20.0);
  world_.turned_rad = 0.5 + std::numbers::pi;  // a network that errs for a moment
  for (int frame = 2; frame < 8; ++frame) EXPECT_LT((wrist_at(frame) - aside).norm(), 30.0) << frame;
  for (int frame = 8; frame < 12; ++frame) wrist_at(frame);
  EXPECT_GT((wrist_at(12) - aside).norm(), 100.0) << "what is seen for long is believed";
}

TEST_F(TrackerTest, AnswersTheSameForTheSameFrames) {
  const auto run = [&] {
    world_ = {.hands = {{}}, .noise_mm = 3.0};
    const Pipeline one = pipeline(1);
    Tracker tracker(one, {});
    TrackedHand last;
    for (int i = 0; i < 20; ++i) last = tracker.update(frame_at(i / 30.0)).at(0);
    return last;
  };
  const TrackedHand first = run();
  const TrackedHand second = run();
  EXPECT_EQ(first.angles, second.angles);
  EXPECT_EQ(first.camera_from_hand.matrix(), second.camera_from_hand.matrix());
}

TEST_F(TrackerTest, EmptyFramesAndOtherCamerasDoNoHarm) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {});
  Frame empty = frame_at(0.0);
  std::ranges::fill(empty.depth_mm.pixels(), 0.0f);
  EXPECT_TRUE(tracker.update(empty).empty());
  world_.hands = {{}};
  EXPECT_EQ(tracker.update(frame_at(0.03)).size(), 1u);
  Frame small = testing::blank_frame(symmetric_camera());
  small.camera.width = small.camera.height = 1;
  small.depth_mm = Image<float>(1, 1, 600.0f);
  small.time_s = 0.06;
  EXPECT_NO_THROW(tracker.update(small));
}

TEST_F(TrackerTest, ASecondThreadGetsAnError) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {});
  std::string error;
  world_.while_searching = [&] {
    std::thread([&] { error = error_of([&] { tracker.update(frame_at(0.1)); }); }).join();
  };
  world_.hands = {{}};
  EXPECT_EQ(tracker.update(frame_at(0.0)).size(), 1u);
  EXPECT_THAT(error, HasSubstr("two threads"));
  world_.while_searching = [] {};
  EXPECT_EQ(tracker.update(frame_at(0.1)).size(), 1u) << "and does no harm";
}

TEST_F(TrackerTest, AnEstimatorThatCallsItGetsAnError) {
  const Pipeline one = pipeline(1);
  Tracker tracker(one, {});
  std::string error;
  world_.while_searching = [&] { error = error_of([&] { tracker.update(frame_at(0.1)); }); };
  world_.hands = {{}};
  EXPECT_EQ(tracker.update(frame_at(0.0)).size(), 1u);
  EXPECT_THAT(error, HasSubstr("own pipeline's estimator"));
}

TEST_F(TrackerTest, OptionsOutOfRangeAreRefused) {
  const Pipeline one = pipeline(1);
  EXPECT_THAT(error_of([&] { Tracker(one, {.smoothing = "butterworth"}); }), HasSubstr("smoothing"));
  EXPECT_THAT(error_of([&] { Tracker(one, {.strength = 0.0}); }), HasSubstr("strength"));
  EXPECT_THAT(error_of([&] { Tracker(one, {.lost_after_s = -1.0}); }), HasSubstr("lost_after_s"));
}

}  // namespace
}  // namespace knuckle
