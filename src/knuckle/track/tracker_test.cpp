// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/tracker.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <thread>

#include "knuckle/camera/projection.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

constexpr double kDepthMm = 600.0;

/// The same in a mirror.
Camera symmetric_camera() {
  Camera camera = testing::quarter_vga_camera();
  camera.cx = 159.5;
  return camera;
}

/// A hand that is really there, as a right or left one.
struct TrueHand {
  Point3 middle{0, 0, kDepthMm};
  HandSide side = HandSide::right;
  float confidence = 0.9f;
};

/// What stubs of segmentation and estimation see: not the images.
struct World {
  std::vector<TrueHand> hands;
  double noise_mm = 0.0;
  double size = 1.0;
  int searches = 0;  // of all of a frame
  int looks = 0;     // of the estimator
  std::function<void()> while_searching = [] {};
  std::function<bool(const Frame&, const std::optional<Point3>&, const TrueHand&)> is_found =
      [](const Frame&, const std::optional<Point3>&, const TrueHand&) { return true; };
  Random random{5};
};

/// Finds the true hands: those within 120 mm of a start, the nearest first, or all of them.
class TrueSegmenter final : public Segmenter {
 public:
  explicit TrueSegmenter(World& world) : world_(world) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found;
    world_.searches += start ? 0 : 1;
    world_.while_searching();
    std::vector<TrueHand> hands = world_.hands;
    const auto distance = [&](const TrueHand& hand) { return (hand.middle - *start).norm(); };
    if (start) std::ranges::stable_sort(hands, {}, distance);
    for (const TrueHand& hand : hands) {
      if (start && (hand.middle - *start).norm() > 120.0) continue;
      if (!world_.is_found(frame, start, hand)) continue;
      if (std::ssize(found.hands) == max_hands) break;
      HandRegion region;
      region.box = {0, 0, 1, 1};
      region.mask = Image<std::uint8_t>(1, 1, 1);
      region.centre = hand.middle;
      region.score = 1.0;
      region.side = hand.side;
      found.hands.push_back(region);
    }
    if (found.hands.empty()) found.reason = "nothing there";
    return found;
  }

 private:
  World& world_;
};

/// Sees an adult's straight hand around the patch's centre, with noise.
class StraightEstimator final : public Estimator {
 public:
  explicit StraightEstimator(World& world) : world_(world) {}
  Convention convention() const override { return superset_convention(); }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& patch) const override {
    ++world_.looks;
    const Projection projection(symmetric_camera());
    const Point3 centre = projection.to_camera(patch.geometry.to_image({0, 0, 0}));
    const auto points =
        landmarks(scaled(adult_skeleton(), world_.size), HandAngles{}, RigidTransform::Identity());
    Point3 mean = Point3::Zero();
    for (const Point3& point : points) mean += point / static_cast<double>(points.size());
    PatchPose pose;
    for (const Point3& point : points) {
      const Point3 noise(world_.random.normal(), world_.random.normal(), world_.random.normal());
      pose.joints.push_back(
          patch.geometry.to_patch(projection.to_image(centre + point - mean + world_.noise_mm * noise)));
      pose.confidence.push_back(confidence_at(centre));
    }
    return pose;
  }

 private:
  float confidence_at(const Point3& centre) const {
    for (const TrueHand& hand : world_.hands) {
      const Point3 mirrored(-hand.middle.x(), hand.middle.y(), kDepthMm);
      if ((hand.middle - centre).norm() < 10.0 || (mirrored - centre).norm() < 10.0) return hand.confidence;
    }
    return 0.1f;
  }

  World& world_;
  PatchExtractor patches_{{.size_px = 32, .mode = "cube", .cube_mm = 250.0}};
};

class TrackerTest : public ::testing::Test {
 protected:
  Pipeline pipeline(int max_hands) {
    return Pipeline({HandFinder(std::make_unique<TrueSegmenter>(world_),
                                {.side = "auto", .max_hands = max_hands, .sure_confidence = 0.45}),
                     std::make_unique<StraightEstimator>(world_)});
  }
  Frame frame_at(double time_s) const {
    Frame frame = testing::blank_frame(symmetric_camera());
    std::ranges::fill(frame.depth_mm.pixels(), static_cast<float>(kDepthMm));
    frame.time_s = time_s;
    return frame;
  }
  /// Whether the frame still shows what is at a hand's middle: it does not, once the hand is taken away.
  static bool shows(const Frame& frame, const TrueHand& hand) {
    const ImagePoint at = Projection(frame.camera).to_image(hand.middle);
    return is_measured(
        frame.depth_mm(static_cast<int>(std::round(at.u)), static_cast<int>(std::round(at.v))));
  }
  static Point3 middle_of(const TrackedHand& hand) {
    return Projection(symmetric_camera()).to_camera(mean_joint(hand.pose));
  }

  World world_;
};

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

TEST_F(TrackerTest, ASearchLeavesHandsThatAreFollowedAlone) {
  const Pipeline two = pipeline(2);
  Tracker tracker(two, {.search_every_s = 0.0});
  world_.hands = {{{-120, 0, kDepthMm}}, {{120, 0, kDepthMm}, HandSide::left}};
  for (int i = 0; i < 10; ++i) tracker.update(frame_at(i / 30.0));
  ASSERT_EQ(world_.searches, 10);
  const int before = world_.looks;
  for (int i = 10; i < 20; ++i) EXPECT_EQ(tracker.update(frame_at(i / 30.0)).size(), 2u);
  EXPECT_EQ(world_.searches, 20);
  const int of_followed = world_.looks - before;
  Tracker without(two, {.search_every_s = 1.0});
  for (int i = 0; i < 10; ++i) without.update(frame_at(i / 30.0));
  const int searches = world_.searches;
  const int begun = world_.looks;
  for (int i = 10; i < 20; ++i) without.update(frame_at(i / 30.0));
  EXPECT_LT(world_.searches - searches, 10);
  EXPECT_EQ(of_followed, world_.looks - begun)
      << "each hand is looked at as often, with searches and without";
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

TEST_F(TrackerTest, TwoHandsKeepTheirIdsAndSides) {
  const Pipeline two = pipeline(2);
  Tracker tracker(two, {});
  world_.hands = {{{-120, 0, kDepthMm}, HandSide::left}, {{120, 0, kDepthMm}, HandSide::right}};
  for (int i = 0; i < 40; ++i) {
    world_.hands[0].middle.y() = 2.0 * i;
    world_.hands[1].middle.y() = -2.0 * i;
    if (i % 7 == 3) std::swap(world_.hands[0], world_.hands[1]);  // their order says nothing
    const auto hands = tracker.update(frame_at(i / 30.0));
    ASSERT_EQ(hands.size(), 2u) << i;
    for (const TrackedHand& hand : hands) {
      EXPECT_EQ(hand.side, hand.id == hands[0].id ? hands[0].side : hands[1].side);
      EXPECT_EQ(middle_of(hand).x() < 0.0, hand.side == HandSide::left);
    }
    EXPECT_EQ(hands[0].id, 1);
    EXPECT_EQ(hands[1].id, 2);
  }
}

TEST_F(TrackerTest, AHandThatComesLaterIsFoundWithinTheTimeOfASearch) {
  const Pipeline two = pipeline(2);
  Tracker tracker(two, {.search_every_s = 0.2});
  world_.hands = {{{-120, 0, kDepthMm}}};
  int first_seen = -1;
  for (int i = 0; i < 40; ++i) {
    if (i == 11) world_.hands.push_back({{120, 0, kDepthMm}});
    if (tracker.update(frame_at(i / 30.0)).size() == 2 && first_seen < 0) first_seen = i;
  }
  EXPECT_GE(first_seen, 11);
  EXPECT_LE(first_seen, 11 + 7);
  EXPECT_LT(world_.searches, 20);
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
  const auto trembling = [&](const TrackerOptions& options, double noise_mm = 1.5) {
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
  EXPECT_LT(weak, 0.8 * raw);
  EXPECT_LT(strong, 0.7 * weak);
  // So little noise is no motion: what is taken of it at rest decides.
  EXPECT_LT(trembling({.smoothing = "one_euro", .strength = 4.0}, 0.05),
            0.6 * trembling({.smoothing = "one_euro"}, 0.05));
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
  EXPECT_THAT(error_of([&] { tracker.update(frame_at(std::nan(""))); }), HasSubstr("not finite"));
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

TEST_F(TrackerTest, OfHandsCloseByEachIsLookedForWithoutTheOther) {
  const Pipeline two = pipeline(2);
  for (const double apart : {150.0, 400.0}) {
    Tracker tracker(two, {});
    world_.hands = {{{-0.5 * apart, 0, kDepthMm}}, {{0.5 * apart, 0, kDepthMm}}};
    int looks = 0;
    for (int i = 0; i < 4; ++i) {
      world_.is_found = [&](const Frame& frame, const std::optional<Point3>& start, const TrueHand& hand) {
        if (!start) return true;
        const TrueHand& other = world_.hands[hand.middle.x() < 0.0 ? 1 : 0];
        EXPECT_TRUE(shows(frame, hand)) << i;
        EXPECT_EQ(shows(frame, other), apart > 300.0) << i;
        ++looks;
        return true;
      };
      ASSERT_EQ(tracker.update(frame_at(i / 30.0)).size(), 2u) << i;
    }
    EXPECT_EQ(looks, 6) << "of both hands, in all frames but the first";
  }
}

TEST_F(TrackerTest, ALostHandIsFoundAgainBesideOneThatHidesItFromSearches) {
  const Pipeline two = pipeline(2);
  for (const bool is_lost_nearby : {true, false}) {
    Tracker tracker(two, {.lost_after_s = 1.0});
    world_ = {};
    world_.hands = {{{-150, 0, kDepthMm}}, {{is_lost_nearby ? 150.0 : 320.0, 0, kDepthMm}}};
    ASSERT_EQ(tracker.update(frame_at(0.0)).size(), 2u);
    world_.hands[1].middle.x() = 20.0;  // farther than it is looked for from where it was
    world_.is_found = [&](const Frame& frame, const std::optional<Point3>&, const TrueHand& hand) {
      return shows(frame, hand) && (hand.middle.x() < 0.0 || !shows(frame, world_.hands[0]));
    };
    const std::vector<TrackedHand> hands = tracker.update(frame_at(0.03));
    ASSERT_EQ(hands.size(), is_lost_nearby ? 2u : 1u) << "what is too far away is no lost hand";
    EXPECT_EQ(hands.back().id, is_lost_nearby ? 2 : 1);
  }
}

TEST_F(TrackerTest, TheForearmOfTheHandBesideIsNoLostHand) {
  const auto points = landmarks(adult_skeleton(), HandAngles{}, RigidTransform::Identity());
  Point3 mean = Point3::Zero();
  for (const Point3& point : points) mean += point / static_cast<double>(points.size());
  const Eigen::Vector3d palm =
      points[static_cast<int>(Landmark::middle_mcp)] - points[static_cast<int>(Landmark::wrist)];
  const Eigen::Vector3d aside = 0.8 * palm.cross(Eigen::Vector3d::UnitZ());
  const Pipeline two = pipeline(2);
  Tracker tracker(two, {.lost_after_s = 1.0});
  const TrueHand first{{0, 0, kDepthMm}};
  const Point3 forearm = first.middle + points[static_cast<int>(Landmark::wrist)] - mean - palm;
  ASSERT_NEAR(palm.z(), 0.0, 20.0) << "nearly in the plane that the frame shows";
  world_.hands = {first, {forearm + 1.5 * aside}};
  ASSERT_EQ(tracker.update(frame_at(0.0)).size(), 2u);
  for (const bool is_forearm : {true, false}) {
    world_.hands[1].middle = forearm;
    if (!is_forearm) world_.hands[1].middle += aside;
    world_.hands[1].middle.z() = kDepthMm;
    world_.is_found = [&](const Frame& frame, const std::optional<Point3>& start, const TrueHand& hand) {
      const bool is_first = hand.middle == first.middle;
      return shows(frame, hand) && (is_first || (!start && !shows(frame, first)));
    };
    EXPECT_EQ(tracker.update(frame_at(is_forearm ? 0.03 : 0.06)).size(), is_forearm ? 1u : 2u);
  }
}

TEST_F(TrackerTest, OfTwoTracksOfOneHandTheOlderOneStays) {
  const Pipeline three = pipeline(3);
  Tracker tracker(three, {});
  world_.hands = {{{-150, 0, kDepthMm}}, {{0, 0, kDepthMm}}, {{150, 0, kDepthMm}}};
  std::vector<TrackedHand> hands;
  for (int i = 0; i < 20; ++i) {
    world_.hands[2].middle.x() = 150.0 - 7.0 * i;  // ends 17 mm beside the second
    hands = tracker.update(frame_at(i / 30.0));
    ASSERT_EQ(hands.at(0).id, 1) << i;
    ASSERT_EQ(hands.at(1).id, 2) << i;
    ASSERT_EQ(hands.size(), (world_.hands[2].middle - world_.hands[1].middle).norm() < 40.0 ? 2u : 3u) << i;
  }
  EXPECT_EQ(hands.size(), 2u);
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

TEST_F(TrackerTest, OptionsOutOfRangeAreRefused) {
  const Pipeline one = pipeline(1);
  EXPECT_THAT(error_of([&] { Tracker(one, {.smoothing = "butterworth"}); }), HasSubstr("smoothing"));
  EXPECT_THAT(error_of([&] { Tracker(one, {.strength = 0.0}); }), HasSubstr("strength"));
  EXPECT_THAT(error_of([&] { Tracker(one, {.lost_after_s = -1.0}); }), HasSubstr("lost_after_s"));
}

}  // namespace
}  // namespace knuckle
