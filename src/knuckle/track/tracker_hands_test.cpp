// SPDX-License-Identifier: Apache-2.0
// Several hands that are followed.
#include "knuckle/track/tracker_testing.h"

namespace knuckle {
namespace {

using testing::kDepthMm;
using testing::TrueHand;

class SeveralHands : public testing::TrackerTest {};

TEST_F(SeveralHands, ASearchLeavesHandsThatAreFollowedAlone) {
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

TEST_F(SeveralHands, TwoHandsKeepTheirIdsAndSides) {
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

TEST_F(SeveralHands, AHandThatComesLaterIsFoundWithinTheTimeOfASearch) {
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

TEST_F(SeveralHands, OfHandsCloseByEachIsLookedForWithoutTheOther) {
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

TEST_F(SeveralHands, ALostHandIsFoundAgainBesideOneThatHidesItFromSearches) {
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

TEST_F(SeveralHands, TheForearmOfTheHandBesideIsNoLostHand) {
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

TEST_F(SeveralHands, ATrackThatLeapsToAnotherOnesHandGoesBack) {
  for (const std::size_t hidden : {0u, 1u}) {  // the older one, the other one
    const Pipeline two = pipeline(2);
    Tracker tracker(two, {.lost_after_s = 1.0});
    world_.hands = {{{0, 0, kDepthMm}}, {{60, 0, kDepthMm}}};
    for (int i = 0; i < 20; ++i) {
      const bool is_hidden = i >= 10 && i < 14;
      world_.is_found = [&](const Frame&, const std::optional<Point3>&, const TrueHand& hand) {
        return !is_hidden || hand.middle != world_.hands[hidden].middle;
      };
      const std::vector<TrackedHand> hands = tracker.update(frame_at(i / 30.0));
      ASSERT_EQ(hands.size(), is_hidden ? 1u : 2u) << i;
      EXPECT_EQ(hands[0].id, is_hidden && hidden == 0 ? 2 : 1) << i;
      if (!is_hidden) {
        EXPECT_EQ(hands[1].id, 2) << i;
      }
    }
  }
}

TEST_F(SeveralHands, OfTwoTracksOfOneHandTheOlderOneStays) {
  const Pipeline three = pipeline(3);
  Tracker tracker(three, {});
  world_.hands = {{{-150, 0, kDepthMm}}, {{0, 0, kDepthMm}}, {{150, 0, kDepthMm}}};
  std::vector<TrackedHand> hands;
  for (int i = 0; i < 20; ++i) {
    world_.hands[2].middle.x() = 150.0 - 7.0 * i;  // ends 17 mm beside the second
    hands = tracker.update(frame_at(i / 30.0));
    ASSERT_EQ(hands.at(0).id, 1) << i;
    ASSERT_EQ(hands.at(1).id, 2) << i;
    const double apart = (world_.hands[2].middle - world_.hands[1].middle).norm();
    if (apart > 44.0) {
      ASSERT_EQ(hands.size(), 3u) << i;
    }
    if (apart < 36.0) {
      ASSERT_EQ(hands.size(), 2u) << i;
    }
  }
  EXPECT_EQ(hands.size(), 2u);
}

}  // namespace
}  // namespace knuckle
