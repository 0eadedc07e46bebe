// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/record_of.h"

#include <array>

#include <gmock/gmock.h>

namespace knuckle {
namespace {

constexpr std::array kTwo = {Landmark::thumb_tip, Landmark::wrist};

HandEstimate hand(double u, double score, HandSide side) {
  HandEstimate estimate;
  estimate.pose = {{"two2", kTwo}, {{u, 30.0, 500.0}, {}}, {0.75f, 0.0f}};
  estimate.score = score;
  estimate.side = side;
  return estimate;
}

FrameResult result_with(std::vector<HandEstimate> hands) {
  FrameResult result;
  result.index = 12;
  result.name = "000034";
  result.time_s = 0.4;
  result.camera = {.width = 80, .height = 60, .fx = 50.0, .fy = 40.0, .cx = 41.0, .cy = 25.0};
  result.estimate.status = "unsure";
  result.estimate.hands = std::move(hands);
  return result;
}

TEST(RecordOf, HoldsWhatWasFoundInTheOrderOfTheHands) {
  const FrameRecord record = record_of(
      result_with({hand(51.0, 0.5, HandSide::left), hand(11.0, 0.25, HandSide::right)}), PixelOrigin::centre);
  EXPECT_EQ(record.frame, 12);
  EXPECT_EQ(record.name, "000034");
  EXPECT_EQ(record.time_s, 0.4);
  EXPECT_EQ(record.status, "unsure");
  EXPECT_FALSE(record.latency_ms);
  ASSERT_EQ(record.hands.size(), 2u);
  EXPECT_EQ(record.hands[0].id, 1);
  EXPECT_EQ(record.hands[0].side, HandSide::left);
  EXPECT_EQ(record.hands[0].score, 0.5);
  EXPECT_EQ(record.hands[0].landmarks_mm[0], Point3(100.0, 62.5, 500.0));
  EXPECT_THAT(record.hands[0].confidence, ::testing::ElementsAre(0.75, 0.0));
  EXPECT_EQ(record.hands[1].id, 2);
  EXPECT_EQ(record.hands[1].side, HandSide::right);
  EXPECT_EQ(record.hands[1].score, 0.25);
  EXPECT_EQ(record.hands[1].landmarks_mm[0], Point3(-300.0, 62.5, 500.0));
  EXPECT_TRUE(record.hands[0].skeleton.empty() && record.hands[0].angles_rad.empty());
}

TEST(RecordOf, HoldsWhatAFittedSkeletonSays) {
  HandEstimate fitted = hand(51.0, 0.5, HandSide::left);
  fitted.id = 9;
  fitted.skeleton = "adult";
  HandAngles angles;
  angles[HandAngle::index_pip] = 0.7;
  fitted.angles = angles;
  const HandRecord record = record_of(result_with({fitted}), PixelOrigin::centre).hands.at(0);
  EXPECT_EQ(record.id, 9);
  EXPECT_EQ(record.skeleton, fitted.skeleton);
  ASSERT_EQ(record.angles_rad.size(), std::size_t{kHandAngleCount});
  for (const auto& [name, radians] : record.angles_rad) EXPECT_EQ(radians, name == "index_pip" ? 0.7 : 0.0);
}

TEST(RecordOf, PixelsAreInTheSourcesOriginAndMissingJointsStayMissing) {
  const FrameResult result = result_with({hand(51.0, 1.0, HandSide::right)});
  const HandRecord centre = record_of(result, PixelOrigin::centre).hands.at(0);
  const HandRecord corner = record_of(result, PixelOrigin::corner).hands.at(0);
  EXPECT_EQ(centre.landmarks_px[0].u, 51.0);
  EXPECT_EQ(centre.landmarks_px[0].v, 30.0);
  EXPECT_EQ(corner.landmarks_px[0].u, 51.5);
  EXPECT_EQ(corner.landmarks_px[0].v, 30.5);
  EXPECT_EQ(corner.landmarks_mm[0], centre.landmarks_mm[0]);
  EXPECT_TRUE(std::isnan(centre.landmarks_px[1].u));
  EXPECT_TRUE(std::isnan(centre.landmarks_mm[1].z()));
}

TEST(RecordOf, AFrameThatCouldNotBeReadHasNoHandsAndNeedsNoCamera) {
  FrameResult result;
  result.index = 7;
  result.name = "a";
  result.estimate.status = "the frame cannot be read: broken";
  const FrameRecord record = record_of(result, PixelOrigin::centre);
  EXPECT_EQ(record.frame, 7);
  EXPECT_EQ(record.name, "a");
  EXPECT_FALSE(record.time_s);
  EXPECT_EQ(record.status, "the frame cannot be read: broken");
  EXPECT_TRUE(record.hands.empty());
}

}  // namespace
}  // namespace knuckle
