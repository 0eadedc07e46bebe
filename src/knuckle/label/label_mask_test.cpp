// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_mask.h"

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/label/label_change.h"
#include "knuckle/label/label_testing.h"
#include "knuckle/label/mask_brush.h"

namespace knuckle {
namespace {

using testing::closing_hand_head;
using testing::error_of;
using ::testing::HasSubstr;

Image<std::uint8_t> painted(const BrushStroke& stroke, int width = 40, int height = 30) {
  Image<std::uint8_t> pixels(width, height);
  paint(stroke, pixels);
  return pixels;
}

TEST(LabelMaskTest, AnyImageComesBackToThePixel) {
  Random random(5);
  for (const double share : {0.0, 0.02, 0.5, 1.0}) {
    Image<std::uint8_t> pixels(23, 17);
    for (std::uint8_t& pixel : pixels.pixels()) pixel = random.uniform() < share ? 1 : 0;
    EXPECT_EQ(pixels_of(mask_from_pixels_of_hand(pixels)), pixels) << share;
  }
}

TEST(LabelMaskTest, RunsThatDoNotFillTheImageAreRefused) {
  EXPECT_THAT(error_of([] { pixels_of({4, 2, {3, 4}}); }), HasSubstr("7 pixels, expected 8 (4x2)"));
  EXPECT_THAT(error_of([] { pixels_of({4, 2, {3, 6}}); }), HasSubstr("expected 0 to 5"));
  EXPECT_THAT(error_of([] { pixels_of({4, 2, {-1, 9}}); }), HasSubstr("run of -1"));
  EXPECT_THAT(error_of([] {
                pixels_of({4, 2, std::vector<std::int64_t>(kMostMaskRuns + 1, 0)});
              }),
              HasSubstr("at most"));
}

TEST(LabelMaskTest, TheBoxHoldsAllPixelsAndNoMore) {
  EXPECT_TRUE(box_of(Image<std::uint8_t>(8, 8)).empty());
  Image<std::uint8_t> pixels(12, 9);
  pixels(3, 7) = pixels(10, 2) = 1;
  EXPECT_EQ(box_of(pixels), (Box{3, 2, 8, 6}));
}

TEST(MaskBrushTest, AStrokePaintsWhatLiesWithinItsRadius) {
  const Image<std::uint8_t> pixels = painted({.points = {{5, 6}, {30, 20}}, .radius_px = 3.5});
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 40; ++column) {
      double nearest = 1e9;  // from the way, in small steps
      for (int i = 0; i <= 2000; ++i)
        nearest = std::min(nearest, std::hypot(column - 5 - i * 0.0125, row - 6 - i * 0.007));
      if (std::abs(nearest - 3.5) < 0.01) continue;
      EXPECT_EQ(pixels(column, row), nearest < 3.5 ? 1 : 0) << column << " " << row;
    }
  }
}

TEST(MaskBrushTest, TheEraserTakesAwayAndTheEdgeOfTheImageIsNoFault) {
  Image<std::uint8_t> pixels = painted({.points = {{-4, -4}, {60, 60}}, .radius_px = 90.0});
  EXPECT_EQ(std::ranges::count(pixels.pixels(), 1), 40 * 30);
  paint({.points = {{10, 10}}, .radius_px = 0.5, .erases = true}, pixels);
  EXPECT_EQ(std::ranges::count(pixels.pixels(), 0), 1);
  EXPECT_EQ(pixels(10, 10), 0);
}

TEST(MaskBrushTest, TheSurfaceOfAHandIsFoundBeforeAWall) {
  const auto points = testing::bent_hand_points(0.3);
  Frame frame = testing::flesh_frame(points);
  const Image<std::uint8_t> found = pixels_near_flesh(frame, points);
  for (int row = 0; row < found.height(); ++row) {
    for (int column = 0; column < found.width(); ++column)
      EXPECT_EQ(found(column, row), frame.depth_mm(column, row) < 800.0f ? 1 : 0) << column << " " << row;
  }
  frame.depth_mm = Image<float>(frame.camera.width, frame.camera.height);
  EXPECT_TRUE(box_of(pixels_near_flesh(frame, points)).empty()) << "nothing was measured";
}

class MaskLineTest : public ::testing::Test {
 protected:
  MaskLineTest() {
    change_.act = LabelAct::brush;
    change_.landmarks.resize(head_.convention.landmarks.size());
    change_.mask = std::make_shared<const LabelMask>(
        mask_from_pixels_of_hand(painted({.points = {{9, 9}}, .radius_px = 4})));
  }
  std::string fault(const std::string& from, const std::string& to) const {
    std::string line = to_json_line(change_, head_.convention);
    const std::size_t at = line.find(from);
    EXPECT_NE(at, std::string::npos);
    line.replace(at, from.size(), to);
    return error_of([&] { parse_label_change(line, head_); });
  }
  LabelHead head_ = closing_hand_head(3);
  LabelChange change_;
};

TEST_F(MaskLineTest, ALineHoldsTheMaskToThePixel) {
  const LabelChange back = parse_label_change(to_json_line(change_, head_.convention), head_);
  ASSERT_TRUE(back.mask);
  EXPECT_EQ(*back.mask, *change_.mask);
}

TEST_F(MaskLineTest, OnlyChangesOfTheMaskSayIt) {
  change_.act = LabelAct::correct;
  EXPECT_EQ(parse_label_change(to_json_line(change_, head_.convention), head_).mask, nullptr);
  change_.act = LabelAct::brush;
  EXPECT_THAT(fault("\"brush\"", "\"verify\""), HasSubstr("mask"));
}

TEST_F(MaskLineTest, NonsenseIsRefused) {
  EXPECT_THAT(fault("[40,30,", "[40,31,"), HasSubstr("expected 1240"));
  EXPECT_THAT(fault("[40,30,", "[40,30,-"), HasSubstr("mask"));
  EXPECT_THAT(fault("[40,30,", "[0,30,"), HasSubstr("expected 1 to"));
  EXPECT_THAT(fault("[40,30,", "[40,30,0.5,"), HasSubstr("whole number"));
  EXPECT_THAT(fault("\"mask\":[", "\"mask\":[["), HasSubstr("not JSON"));
  EXPECT_THAT(fault("\"mask\":[40,30", "\"mask\":[70000,70000"), HasSubstr("expected 1 to"));
}

}  // namespace
}  // namespace knuckle
