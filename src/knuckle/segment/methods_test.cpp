// SPDX-License-Identifier: Apache-2.0
// What each segmentation method does in its own way.
#include <cmath>
#include <numbers>

#include "knuckle/core/testing.h"
#include "knuckle/segment/mean_shift_segmenter.h"
#include "knuckle/segment/testing.h"
#include "knuckle/segment/threshold_segmenter.h"

namespace knuckle {
namespace {

using ::knuckle::testing::blank_frame;
using ::knuckle::testing::draw_ball;
using ::knuckle::testing::draw_rod;
using ::knuckle::testing::hand_frame;
using ::knuckle::testing::quarter_vga_camera;

bool is_in_mask(const HandRegion& hand, int column, int row) {
  return hand.box.contains(column, row) && hand.mask(column - hand.box.x, row - hand.box.y) == 1;
}

TEST(MeanShiftSegmenter, HandIsWhatTheKernelReaches) {
  const MeanShiftSegmenter segmenter{MeanShiftSegmenterOptions{}};
  const double reach = 13.5 * std::log(1e5);
  EXPECT_NEAR(reach, 155.4, 0.05);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Frame frame = hand_frame(seed);
    const Segmentation found = segmenter.segment(frame, std::nullopt, 1);
    ASSERT_EQ(found.hands.size(), 1u);
    const HandRegion& hand = found.hands[0];
    const Projection projection(frame.camera);
    for (int row = 0; row < 240; ++row) {
      for (int column = 0; column < 320; ++column) {
        const float depth = frame.depth_mm(column, row);
        if (!is_measured(depth)) continue;
        const Point3 point = projection.to_camera({double(column), double(row), depth});
        const double distance = (point - hand.centre).norm();
        if (std::abs(distance - reach) < 0.01) continue;
        EXPECT_EQ(is_in_mask(hand, column, row), distance < reach);
      }
    }
  }
}

TEST(MeanShiftSegmenter, StartsWhereItIsTold) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(-200, 0, 500), 60);
  draw_ball(frame, Point3(220, 0, 700), 60);
  const MeanShiftSegmenter segmenter{MeanShiftSegmenterOptions{}};
  EXPECT_LT(segmenter.segment(frame, std::nullopt, 1).hands.at(0).centre.x(), -100);
  EXPECT_GT(segmenter.segment(frame, Point3(180, 0, 700), 1).hands.at(0).centre.x(), 100);
  const Segmentation lost = segmenter.segment(frame, Point3(0, 0, 3000), 1);
  EXPECT_TRUE(lost.hands.empty());
  EXPECT_EQ(lost.reason, "no measurement near the start");
}

TEST(MeanShiftSegmenter, ScoresAnUnboundedPlaneWithOne) {
  // On a grid of pixels 1 mm apart, seen in parallel.
  Camera camera = quarter_vga_camera();
  camera.model = CameraModel::orthographic;
  camera.fx = camera.fy = 1.0;
  Frame frame = blank_frame(camera);
  std::ranges::fill(frame.depth_mm.pixels(), 600.0f);
  const MeanShiftSegmenter segmenter{MeanShiftSegmenterOptions{}};
  EXPECT_NEAR(segmenter.segment(frame, Point3(0, 0, 600), 1).hands.at(0).score, 1.0, 0.01);
  // A finger's width of it.
  for (int row = 0; row < 240; ++row) {
    for (int column = 0; column < 320; ++column) {
      if (std::abs(row - 120) > 9) frame.depth_mm(column, row) = 0.0f;
    }
  }
  EXPECT_LT(segmenter.segment(frame, Point3(0, 0, 600), 1).hands.at(0).score, 0.8);
}

TEST(MeanShiftSegmenter, LeavesTheFirstHandsPointsOutOfTheSecond) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(-130, 0, 500), 60);
  draw_ball(frame, Point3(130, 0, 500), 60);
  const Segmentation found = MeanShiftSegmenter(MeanShiftSegmenterOptions{}).segment(frame, std::nullopt, 2);
  ASSERT_EQ(found.hands.size(), 2u);
  for (int row = 0; row < 240; ++row) {
    for (int column = 0; column < 320; ++column) {
      EXPECT_FALSE(is_in_mask(found.hands[0], column, row) && is_in_mask(found.hands[1], column, row));
    }
  }
}

TEST(MeanShiftSegmenter, TakesNoSecondHandWithinTheSeparation) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(-130, 0, 500), 60);
  draw_ball(frame, Point3(130, 0, 500), 60);
  const auto hands_at = [&](double separation_mm) {
    MeanShiftSegmenterOptions options;
    options.separation_mm = separation_mm;
    return MeanShiftSegmenter(options).segment(frame, std::nullopt, 2).hands.size();
  };
  EXPECT_EQ(hands_at(0.0), 2u);
  EXPECT_EQ(hands_at(300.0), 1u);
}

TEST(MeanShiftSegmenter, TheSurestHandComesFirstWhicheverIsNearer) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(-150, 0, 450), 40);
  draw_ball(frame, Point3(150, 0, 550), 75);
  const Segmentation found = MeanShiftSegmenter(MeanShiftSegmenterOptions{}).segment(frame, std::nullopt, 2);
  ASSERT_EQ(found.hands.size(), 2u);
  EXPECT_GT(found.hands[0].score, found.hands[1].score);
  EXPECT_GT(found.hands[0].centre.x(), 0.0);
}

TEST(MeanShiftSegmenter, TakesNoWallForAHandUnlessItIsToldTo) {
  Frame frame = blank_frame(quarter_vga_camera());
  std::ranges::fill(frame.depth_mm.pixels(), 900.0f);
  const MeanShiftSegmenter segmenter{MeanShiftSegmenterOptions{}};
  const Segmentation found = segmenter.segment(frame, std::nullopt, 1);
  EXPECT_TRUE(found.hands.empty());
  EXPECT_THAT(found.reason, ::testing::HasSubstr("a hand at most 40000"));
  EXPECT_EQ(segmenter.segment(frame, Point3(0, 0, 900), 1).hands.size(), 1u);
}

TEST(MeanShiftSegmenter, FindsTheHandBehindASpeckleThatLeadsIntoTheTrunk) {
  Frame frame = blank_frame(quarter_vga_camera());
  const RayTable rays(frame.camera);
  draw_rod(frame, rays, Point3(100, -150, 800), Point3(100, 300, 800), 160);  // trunk
  draw_ball(frame, Point3(-160, 0, 680), 55);                                 // hand
  draw_ball(frame, Point3(150, 100, 600), 12);                                // speckle
  const Segmentation found = MeanShiftSegmenter(MeanShiftSegmenterOptions{}).segment(frame, std::nullopt, 1);
  ASSERT_EQ(found.hands.size(), 1u);
  EXPECT_NEAR(found.hands[0].centre.x(), -155, 15);
  MeanShiftSegmenterOptions unbounded;
  unbounded.max_area_mm2 = 1e6;
  EXPECT_GT(MeanShiftSegmenter(unbounded).segment(frame, std::nullopt, 1).hands.at(0).centre.x(), 50);
}

TEST(MeanShiftSegmenter, RefusesAreasInTheWrongOrder) {
  MeanShiftSegmenterOptions options;
  options.max_area_mm2 = 1000.0;
  EXPECT_THAT(testing::error_of([&] { MeanShiftSegmenter segmenter(options); }),
              ::testing::HasSubstr("min_area_mm2 <= max_area_mm2"));
}

TEST(MeanShiftSegmenter, GivesUpAfterTheGivenCandidates) {
  Frame frame = blank_frame(quarter_vga_camera());
  for (int i = 0; i < 3; ++i) draw_ball(frame, Point3(-240 + 240 * i, 0, 400), 10);
  draw_ball(frame, Point3(0, 0, 900), 80);
  MeanShiftSegmenterOptions options;
  EXPECT_EQ(MeanShiftSegmenter(options).segment(frame, std::nullopt, 1).hands.size(), 1u);
  options.max_candidates = 2;
  EXPECT_TRUE(MeanShiftSegmenter(options).segment(frame, std::nullopt, 1).hands.empty());
}

TEST(ThresholdSegmenter, TakesTheIntervalOfThePaper) {
  Frame frame = blank_frame(quarter_vga_camera());
  for (int row = 0; row < 240; ++row) {
    for (int column = 0; column < 320; ++column)
      frame.depth_mm(column, row) = 400.0f + 2.0f * static_cast<float>(column);
  }
  const Segmentation found = ThresholdSegmenter(ThresholdSegmenterOptions{}).segment(frame, std::nullopt, 1);
  ASSERT_EQ(found.hands.size(), 1u);
  // The median at the border's columns 0 to 2 is that of column 1, at the corners no window is half full.
  EXPECT_EQ(found.hands[0].box, (Box{0, 0, 152, 240}));
}

TEST(ThresholdSegmenter, TakesHalfTheRangeBeforeAndBehindAGivenStart) {
  Frame frame = blank_frame(quarter_vga_camera());
  const std::vector<float> depths = {440, 451, 500, 549, 560};
  for (std::size_t i = 0; i < depths.size(); ++i) frame.depth_mm(100 + static_cast<int>(i), 50) = depths[i];
  ThresholdSegmenterOptions options;
  options.range_mm = 100.0;
  options.min_area_mm2 = 0.0;
  const Segmentation found = ThresholdSegmenter(options).segment(frame, Point3(0, 0, 500), 1);
  ASSERT_EQ(found.hands.size(), 1u);
  EXPECT_EQ(found.hands[0].box, (Box{101, 50, 3, 1}));
}

TEST(ThresholdSegmenter, TakesAFixedIntervalWhereAsked) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(-100, 0, 400), 60);
  draw_ball(frame, Point3(150, 0, 800), 60);
  ThresholdSegmenterOptions options;
  options.interval = "fixed";
  options.near_mm = 700;
  options.far_mm = 900;
  const ThresholdSegmenter segmenter(options);
  EXPECT_GT(segmenter.segment(frame, std::nullopt, 1).hands.at(0).centre.x(), 100);
  EXPECT_GT(segmenter.segment(frame, Point3(-100, 0, 400), 1).hands.at(0).centre.x(), 100);
}

TEST(ThresholdSegmenter, TakesTheLargestComponentWhereAsked) {
  Frame frame = blank_frame(quarter_vga_camera());
  draw_ball(frame, Point3(-200, 0, 480), 40);
  draw_ball(frame, Point3(150, 0, 500), 60);
  ThresholdSegmenterOptions options;
  EXPECT_GT(ThresholdSegmenter(options).segment(frame, std::nullopt, 1).hands.at(0).box.width, 150);
  options.pixels = "component";
  const Segmentation found = ThresholdSegmenter(options).segment(frame, std::nullopt, 1);
  ASSERT_EQ(found.hands.size(), 1u);
  EXPECT_LT(found.hands[0].box.width, 80);
  EXPECT_GT(found.hands[0].centre.x(), 100);
}

/// A camera of four times as many pixels a side.
Camera large_camera() {
  Camera camera = testing::quarter_vga_camera();
  camera.width *= 4;
  camera.height *= 4;
  camera.fx *= 4;
  camera.fy *= 4;
  camera.cx *= 4;
  camera.cy *= 4;
  return camera;
}

TEST(MeanShiftSegmenter, FindsAllPixelsOfAHandInAnImageThatIsThinnedForTheSearch) {
  Frame frame = blank_frame(large_camera());
  draw_ball(frame, Point3(-60, 20, 500), 55);
  const Segmentation alone = MeanShiftSegmenter(MeanShiftSegmenterOptions{}).segment(frame, std::nullopt, 1);
  ASSERT_EQ(alone.hands.size(), 1u);
  for (float& depth : frame.depth_mm.pixels()) depth = is_measured(depth) ? depth : 1500.0f;  // a wall behind
  const Segmentation found = MeanShiftSegmenter(MeanShiftSegmenterOptions{}).segment(frame, std::nullopt, 1);
  ASSERT_EQ(found.hands.size(), 1u);
  EXPECT_LT((found.hands[0].centre - alone.hands[0].centre).norm(), 0.3);
  EXPECT_EQ(found.hands[0].box, alone.hands[0].box);
  EXPECT_EQ(found.hands[0].mask, alone.hands[0].mask);
  EXPECT_NEAR(found.hands[0].score, alone.hands[0].score, 0.02);
}

TEST(MeanShiftSegmenter, KeepsHandsApartInAnImageThatIsThinnedForTheSearch) {
  Frame frame = blank_frame(large_camera());
  draw_ball(frame, Point3(-110, 0, 500), 55);
  draw_ball(frame, Point3(110, 10, 520), 50);
  for (float& depth : frame.depth_mm.pixels()) depth = is_measured(depth) ? depth : 1500.0f;
  const Segmentation found = MeanShiftSegmenter(MeanShiftSegmenterOptions{}).segment(frame, std::nullopt, 2);
  ASSERT_EQ(found.hands.size(), 2u);
  EXPECT_TRUE(intersection(found.hands[0].box, found.hands[1].box).empty());
}

TEST(MeanShiftSegmenter, TakesNoWallForAHandHoweverManyPixelsItHas) {
  for (const bool is_large : {false, true}) {
    Frame frame = blank_frame(is_large ? large_camera() : testing::quarter_vga_camera());
    Random random(7);
    for (float& depth : frame.depth_mm.pixels()) depth = static_cast<float>(900.0 + 2.0 * random.normal());
    const Segmentation found =
        MeanShiftSegmenter(MeanShiftSegmenterOptions{}).segment(frame, std::nullopt, 4);
    EXPECT_TRUE(found.hands.empty());
    EXPECT_THAT(found.reason, ::testing::HasSubstr("a hand at most 40000"));
  }
}

}  // namespace
}  // namespace knuckle
