// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_segmenter.h"

#include <algorithm>

#include "knuckle/core/testing.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/segment/hand_region.h"
#include "knuckle/segment/segmenter_factory.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using testing::blank_frame;
using testing::constant_detector;
using testing::draw_ball;
using testing::error_of;
using ::testing::HasSubstr;
using testing::put_depth;
using testing::quarter_vga_camera;
using testing::small_detector;

const DetectedHand kSeen{.centre = Point3(-40, 30, 520),
                         .extent_mm = 70.0,
                         .score = 0.9,
                         .side = HandSide::left,
                         .side_confidence = 0.8};

class DetectorSegmenterTest : public ::testing::Test {
 protected:
  DetectorSegmenterTest() { draw_ball(frame_, kSeen.centre, 50); }

  DetectorSegmenter segmenter(const DetectorSegmenterOptions& options = {}) const {
    return {constant_detector(small_detector(), frame_.camera, kSeen), options};
  }

  Frame frame_ = blank_frame(quarter_vga_camera());
};

TEST_F(DetectorSegmenterTest, AHandIsWhatLiesInTheBallAroundItsCentre) {
  draw_ball(frame_, Point3(150, 30, 300), 50);              // nearer, and no hand
  draw_ball(frame_, kSeen.centre + Point3(75, 0, 30), 60);  // an arm, in part within the ball
  const Segmentation found = segmenter().segment(frame_, std::nullopt, 4);
  ASSERT_EQ(found.hands.size(), 1u);
  const HandRegion& hand = found.hands[0];
  EXPECT_LT((hand.centre - kSeen.centre).norm(), 1.5) << "but for half precision";
  EXPECT_NEAR(hand.score, 0.9, 0.002);
  EXPECT_EQ(hand.side, HandSide::left);
  const RayTable rays(frame_.camera);
  int near_the_edge = 0;
  for (int row = 0; row < 240; ++row) {
    for (int column = 0; column < 320; ++column) {
      const float depth = frame_.depth_mm(column, row);
      if (!is_measured(depth)) continue;
      const Point3 point(rays.x(column, row, depth), rays.y(column, row, depth), depth);
      const double distance = (point - hand.centre).norm();
      if (std::abs(distance - 95.0) < 0.2) continue;
      const bool is_hand = hand.box.contains(column, row) && hand.mask(column - hand.box.x, row - hand.box.y);
      EXPECT_EQ(is_hand, distance < 95.0);
      near_the_edge += distance > 80.0 && distance < 110.0;
    }
  }
  EXPECT_GT(near_the_edge, 50);
}

/// A table: the plane z = depth.
void draw_table(Frame& frame, double depth_mm) {
  for (int row = 0; row < frame.depth_mm.height(); ++row) {
    for (int column = 0; column < frame.depth_mm.width(); ++column) put_depth(frame, column, row, depth_mm);
  }
}

int pixels_of(const HandRegion& hand) {
  return static_cast<int>(std::ranges::count(hand.mask.pixels(), 1));
}

TEST_F(DetectorSegmenterTest, TheTableBehindAHandIsNotHand) {
  const int alone = pixels_of(segmenter().segment(frame_, std::nullopt, 1).hands.at(0));
  draw_table(frame_, kSeen.centre.z() + 40);  // it cuts the ball of the hand
  const HandRegion cut = segmenter().segment(frame_, std::nullopt, 1).hands.at(0);
  // 6 mm are taken for the table: of a ball of 50 mm, 40 mm before it, a rim of little more than a
  // millimetre.
  EXPECT_NEAR(pixels_of(cut), alone, 0.06 * alone);
  DetectorSegmenterOptions options;
  options.cut_surface = false;
  const HandRegion whole = segmenter(options).segment(frame_, std::nullopt, 1).hands.at(0);
  EXPECT_GT(pixels_of(whole), 1.5 * alone);
  EXPECT_EQ(cut.centre, whole.centre);
  EXPECT_EQ(cut.score, whole.score);
}

TEST_F(DetectorSegmenterTest, WhereNoHandWouldRemainNothingIsCut) {
  Frame table = blank_frame(quarter_vga_camera());
  draw_table(table, kSeen.centre.z());
  const HandRegion found = segmenter().segment(table, std::nullopt, 1).hands.at(0);
  EXPECT_GT(pixels_of(found), 3000);
}

TEST_F(DetectorSegmenterTest, ARegionInAMirrorHasTheOtherSide) {
  const DetectorSegmenter there = segmenter();
  HandRegion hand = there.segment(frame_, std::nullopt, 1).hands.at(0);
  hand = mirrored(hand, 320);
  EXPECT_EQ(hand.side, HandSide::right);
  EXPECT_EQ(mirrored(hand, 320).side, HandSide::left);
}

TEST_F(DetectorSegmenterTest, AStartIsTrusted) {
  const DetectorSegmenter there = segmenter();
  const Segmentation near = there.segment(frame_, Point3(-40, 70, 540), 1);
  ASSERT_EQ(near.hands.size(), 1u);
  EXPECT_LT((near.hands[0].centre - kSeen.centre).norm(), 1.5) << "the hand that was meant";

  const Point3 other(150, 30, 300);
  draw_ball(frame_, other, 50);
  const Segmentation elsewhere = there.segment(frame_, other, 1);
  ASSERT_EQ(elsewhere.hands.size(), 1u);
  EXPECT_EQ(elsewhere.hands[0].centre, other);
  EXPECT_FALSE(elsewhere.hands[0].side.has_value()) << "the detector sees no hand there";
  EXPECT_GT(elsewhere.hands[0].score, 0.0);
  const Segmentation both = there.segment(frame_, other, 2);
  ASSERT_EQ(both.hands.size(), 2u);
  EXPECT_GT(both.hands[0].score, both.hands[1].score) << "surest first";
  EXPECT_NEAR(both.hands[0].likelihood.value(), 0.9, 0.002) << "the detector found it";
  EXPECT_FALSE(both.hands[1].likelihood) << "that somebody pointed at it says more than the detector";
  EXPECT_FALSE(near.hands[0].likelihood);

  const Segmentation lost = there.segment(frame_, Point3(0, 0, 3000), 2);
  EXPECT_TRUE(lost.hands.empty());
  EXPECT_EQ(lost.reason, "no measurement near the start");
}

TEST_F(DetectorSegmenterTest, AStartMayLieInTheCameraItself) {
  Frame wall = blank_frame(quarter_vga_camera());
  draw_table(wall, 60.0);
  for (const double z : {0.0, -20.0, 1e-300}) {
    const Segmentation found = segmenter().segment(wall, Point3(0, 0, z), 1);
    ASSERT_EQ(found.hands.size(), 1u) << z;
    EXPECT_GT(pixels_of(found.hands[0]), 1000) << z;
  }
}

TEST_F(DetectorSegmenterTest, WhatIsNotSureIsNotFound) {
  DetectorSegmenterOptions options;
  options.detection.min_score = 0.95;
  const Segmentation found = segmenter(options).segment(frame_, std::nullopt, 1);
  EXPECT_TRUE(found.hands.empty());
  EXPECT_EQ(found.reason, "the detector sees no hand in the frame");
}

TEST_F(DetectorSegmenterTest, AHandHasASurface) {
  Frame blank = blank_frame(quarter_vga_camera());
  EXPECT_EQ(segmenter().segment(blank, std::nullopt, 1).reason, "no surface was measured in the frame");
  draw_ball(blank, kSeen.centre, 12);
  EXPECT_THAT(segmenter().segment(blank, std::nullopt, 1).reason, HasSubstr("a hand at least 1500"));
  EXPECT_FALSE(segmenter().segment(Frame{}, std::nullopt, 1).reason.empty());
  DetectorSegmenterOptions any_size;
  any_size.min_area_mm2 = 0.0;
  const Segmentation lost = segmenter(any_size).segment(blank, Point3(0, 0, 3000), 1);
  EXPECT_TRUE(lost.hands.empty());
  EXPECT_EQ(lost.reason, "no measurement near the start");
}

TEST_F(DetectorSegmenterTest, RefusesWhatOthersRefuse) {
  EXPECT_THAT(error_of([&] { (void)segmenter().segment(frame_, std::nullopt, 17); }), HasSubstr("max_hands"));
  EXPECT_THAT(error_of([&] { (void)segmenter().segment(frame_, Point3(0, kNaN, 1), 1); }),
              HasSubstr("finite"));
  frame_.camera.width = 321;
  EXPECT_THAT(error_of([&] { (void)segmenter().segment(frame_, std::nullopt, 1); }), HasSubstr("321"));
}

TEST_F(DetectorSegmenterTest, IsMadeFromItsFile) {
  const testing::TemporaryFolder folder;
  save_detector_weights(folder / "hands.pt", constant_detector(small_detector(), frame_.camera, kSeen));
  const std::string table = "method = \"detector\"\nmodel = \"" + (folder / "hands.pt").string() + "\"\n";
  const auto made = create_segmenter(OptionTable::parse(table + "min_score = 0.2", "a.toml"));
  EXPECT_EQ(made->segment(frame_, std::nullopt, 1).hands.size(), 1u);
  EXPECT_THAT(error_of([&] { create_segmenter(OptionTable::parse(table + "min_scor = 1", "a.toml")); }),
              HasSubstr("min_scor"));
  EXPECT_THAT(error_of([] { create_segmenter(OptionTable::parse("method = \"detector\"", "a.toml")); }),
              HasSubstr("model"));
}

}  // namespace
}  // namespace knuckle
