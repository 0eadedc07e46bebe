// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/occlusion_count.h"

#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TrueHand true_hand(std::vector<Occluder> occluders) {
  TrueHand hand;
  for (std::size_t i = 0; i < occluders.size(); ++i)
    hand.landmarks_mm.emplace_back(10.0 * static_cast<double>(i), 0.0, 500.0);
  hand.occluders = std::move(occluders);
  return hand;
}

/// Each landmark of the hand moved along z by its own distance.
HandRecord moved(const TrueHand& hand, const std::vector<double>& away_mm, std::vector<double> confidence) {
  HandRecord record;
  for (std::size_t i = 0; i < away_mm.size(); ++i)
    record.landmarks_mm.emplace_back(hand.landmarks_mm[i] + Point3(0, 0, away_mm[i]));
  record.confidence.assign(confidence.begin(), confidence.end());
  return record;
}

const OcclusionScore& of(const OcclusionScores& scores, Occluder occluder) {
  return scores[static_cast<std::size_t>(occluder)];
}

void expect_near(const OcclusionScore& score, const OcclusionScore& expected) {
  EXPECT_EQ(score.joints, expected.joints);
  EXPECT_NEAR(score.mean_3d_mm, expected.mean_3d_mm, 1e-12);
  EXPECT_NEAR(score.within, expected.within, 1e-12);
  EXPECT_NEAR(score.confidence, expected.confidence, 1e-7);
}

TEST(OcclusionScore, EachLandmarkCountsForWhatLiesBeforeIt) {
  const TrueHand hand = true_hand({Occluder::none, Occluder::object, Occluder::object, Occluder::own_hand});
  OcclusionCount count;
  count.add(hand, moved(hand, {4, 10, 30, 25}, {0.9, 0.5, 0.25, 0.125}), std::vector<int>{0, 1, 2, 3});
  count.add(hand, moved(hand, {8, kNaN, 20, 5}, {0.7, 0.1, 0.75, 0.375}), std::vector<int>{0, 1, 2, 3});
  const OcclusionScores scores = count.scores();
  expect_near(of(scores, Occluder::none), {2, 6.0, 1.0, 0.8});
  expect_near(of(scores, Occluder::object), {3, 20.0, 2.0 / 3.0, 0.5});
  expect_near(of(scores, Occluder::own_hand), {2, 15.0, 0.5, 0.25});
  EXPECT_EQ(of(scores, Occluder::border).joints, 0);
  EXPECT_TRUE(std::isnan(of(scores, Occluder::border).mean_3d_mm));
  expect_near(hidden_of(scores), {5, 18.0, 0.6, 0.4});
}

TEST(OcclusionScore, LandmarksAreFoundByTheirPlaces) {
  const TrueHand hand = true_hand({Occluder::none, Occluder::person, Occluder::border});
  OcclusionCount count;
  count.add(hand, moved(hand, {3, 14}, {}), std::vector<int>{1, -1, 0});
  const OcclusionScores scores = count.scores();
  EXPECT_NEAR(of(scores, Occluder::none).mean_3d_mm, std::hypot(10, 14), 1e-12);
  EXPECT_EQ(of(scores, Occluder::person).joints, 0) << "the estimate lacks it";
  EXPECT_NEAR(of(scores, Occluder::border).mean_3d_mm, std::hypot(20, 3), 1e-12);
  EXPECT_TRUE(std::isnan(of(scores, Occluder::none).confidence)) << "the method gives none";
  EXPECT_TRUE(std::isnan(hidden_of(scores).confidence));
}

TEST(OcclusionScore, NothingIsCountedWhereNobodyKnows) {
  TrueHand hand = true_hand({Occluder::none, Occluder::object});
  hand.occluders.clear();
  OcclusionCount count;
  count.add(hand, moved(hand, {1, 2}, {0.5, 0.5}), std::vector<int>{0, 1});
  for (const OcclusionScore& score : count.scores()) EXPECT_EQ(score.joints, 0);
}

TEST(OcclusionScore, NamesAreThoseOfFiles) {
  EXPECT_EQ(name_of(Occluder::none), "none");
  EXPECT_EQ(name_of(Occluder::own_hand), "own_hand");
  EXPECT_EQ(name_of(Occluder::other_hand), "other_hand");
  EXPECT_EQ(name_of(Occluder::person), "person");
  EXPECT_EQ(name_of(Occluder::object), "object");
  EXPECT_EQ(name_of(Occluder::border), "border");
}

}  // namespace
}  // namespace knuckle
