// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/reliability.h"

#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

const Convention& icg() {
  return convention_from_name("icg20");
}

std::vector<Point3> joints_at(const Point3& place) {
  return std::vector<Point3>(static_cast<std::size_t>(icg().size()), place);
}

const Point3 kNear(0.0, 0.0, 500.0);
const Point3 kFar(200.0, 0.0, 500.0);

/// All joints have that confidence; the first `wrong` of them lie 21 mm beside `place`, the others 19 mm.
HandRecord hand_with(double confidence, int wrong, const Point3& place, HandSide side = HandSide::right) {
  HandRecord hand;
  hand.side = side;
  hand.convention = icg();
  for (int i = 0; i < icg().size(); ++i)
    hand.landmarks_mm.emplace_back(place + Point3(0.0, i < wrong ? 21.0 : 19.0, 0.0));
  hand.confidence.assign(hand.landmarks_mm.size(), confidence);
  return hand;
}

FrameRecord record_with(std::vector<HandRecord> hands) {
  FrameRecord record;
  record.hands = std::move(hands);
  return record;
}

TrueHands two_hands() {
  return {0, {{HandSide::right, joints_at(kNear), 1.0}, {HandSide::left, joints_at(kFar), 1.0}}};
}

TEST(ReliabilityTest, HasARecordForEachFrame) {
  const std::vector<TrueHands> truth(2, two_hands());
  EXPECT_THAT(knuckle::testing::error_of([&] { reliability_of(icg(), truth, std::vector<FrameRecord>(1)); }),
              ::testing::HasSubstr("1 records, expected one for each of 2 frames"));
}

TEST(ReliabilityTest, CountsJointsByTheirConfidence) {
  const std::vector<TrueHands> truth(2, two_hands());
  const std::vector<FrameRecord> records{record_with({hand_with(0.75, 5, kNear)}),
                                         record_with({hand_with(0.25, 20, kFar, HandSide::left)})};
  const Reliability reliability = reliability_of(icg(), truth, records);
  EXPECT_EQ(reliability.joints, 40);
  EXPECT_EQ(reliability.bins[7].joints, 20);
  EXPECT_NEAR(reliability.bins[7].confidence, 0.75, 1e-9);
  EXPECT_NEAR(reliability.bins[7].within, 0.75, 1e-9);
  EXPECT_NEAR(reliability.bins[2].within, 0.0, 1e-9);
  EXPECT_EQ(reliability.bins[0].joints, 0);
  EXPECT_TRUE(std::isnan(reliability.bins[0].within));
  EXPECT_NEAR(reliability.error, 0.5 * 0.25, 1e-9);
}

TEST(ReliabilityTest, ConfidencesOfZeroAndOneHaveABin) {
  const std::vector<TrueHands> truth(2, two_hands());
  const std::vector<FrameRecord> records{record_with({hand_with(1.0, 0, kNear)}),
                                         record_with({hand_with(0.0, 20, kNear)})};
  const Reliability reliability = reliability_of(icg(), truth, records);
  EXPECT_EQ(reliability.bins.back().joints, 20);
  EXPECT_EQ(reliability.bins.front().joints, 20);
  EXPECT_NEAR(reliability.error, 0.0, 1e-9);
}

TEST(ReliabilityTest, AHandInAWrongPlaceCountsAndOneOfTheOtherSideDoesNot) {
  const std::vector<TrueHands> truth(3, two_hands());
  const Point3 nowhere(-500.0, 0.0, 500.0);
  const std::vector<FrameRecord> records{
      record_with({hand_with(0.9, 0, nowhere)}),
      record_with({hand_with(0.9, 0, kFar, HandSide::right)}),  // a left hand stands there
      record_with({})};
  const Reliability reliability = reliability_of(icg(), truth, records);
  EXPECT_EQ(reliability.joints, 20);
  EXPECT_NEAR(reliability.error, 0.9, 1e-9);
}

TEST(ReliabilityTest, WhatIsNotKnownIsNotCounted) {
  std::vector<TrueHands> truth(3, two_hands());
  truth[0].hands[0].landmarks_mm[3] = Point3::Constant(kNaN);
  truth[2].hands.clear();
  HandRecord unsaid = hand_with(0.5, 0, kNear);
  unsaid.confidence.clear();
  const std::vector<FrameRecord> records{record_with({hand_with(0.5, 0, kNear)}), record_with({unsaid}),
                                         record_with({hand_with(0.5, 0, kNear)})};
  EXPECT_EQ(reliability_of(icg(), truth, records).joints, 19);
  EXPECT_THAT(error_of([&] { reliability_of(icg(), truth, {}); }), HasSubstr("3 frames"));
  const Reliability none = reliability_of(icg(), {}, {});
  EXPECT_EQ(none.joints, 0);
  EXPECT_TRUE(std::isnan(none.error));
}

}  // namespace
}  // namespace knuckle
