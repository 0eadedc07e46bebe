// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/drawing.h"

#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using knuckle::testing::error_of;
using ::testing::HasSubstr;

int lightness(const Rgb& colour) {
  return colour.red + colour.green + colour.blue;
}

TEST(DepthColours, AreBrighterNearerAndDarkestWithoutMeasurement) {
  Image<float> depth(40, 1);
  for (int i = 1; i < 40; ++i) depth(i, 0) = 490.0f + 3.0f * static_cast<float>(i);
  const Image<Rgb> picture = colour_mapped(depth, {500.0, 600.0});
  for (int i = 2; i < 40; ++i) EXPECT_LE(lightness(picture(i, 0)), lightness(picture(i - 1, 0)));
  EXPECT_EQ(picture(1, 0), picture(2, 0));    // both before the range
  EXPECT_EQ(picture(38, 0), picture(39, 0));  // both behind it
  EXPECT_LT(lightness(picture(0, 0)), lightness(picture(39, 0)));
  EXPECT_GT(lightness(picture(1, 0)), 2 * lightness(picture(39, 0)));
}

TEST(DepthRange, LeavesOutliersAndHolesOut) {
  Image<float> depth(20, 20, 700.0f);
  depth(0, 0) = 0.0f;
  depth(1, 0) = 50.0f;
  depth(2, 0) = 9000.0f;
  for (int i = 0; i < 20; ++i) depth(i, 10) = 650.0f;
  const DepthRange range = depth_range_in(depth, {0, 0, 20, 20});
  EXPECT_EQ(range.near_mm, 650.0);
  EXPECT_EQ(range.far_mm, 700.0);
  EXPECT_LT(depth_range_in(depth, {50, 50, 5, 5}).near_mm, depth_range_in(depth, {50, 50, 5, 5}).far_mm);
}

TEST(Picture, ShowsTheCropEnlarged) {
  Image<float> depth(10, 10, 600.0f);
  depth(4, 5) = 500.0f;
  const View view{{3, 4, 4, 4}, 8.0};
  const Image<Rgb> picture = picture_of(depth, view, {500.0, 600.0});
  const Rgb near = colour_mapped(Image<float>(1, 1, 500.0f), {500.0, 600.0})(0, 0);
  ASSERT_EQ(picture.width(), 32);
  ASSERT_EQ(picture.height(), 32);
  for (int row = 0; row < 32; ++row) {
    for (int column = 0; column < 32; ++column) {
      EXPECT_EQ(picture(column, row) == near, column / 8 == 1 && row / 8 == 1);
    }
  }
}

TEST(Picture, MayReachBeyondTheBorderOrHaveNoImageAtAll) {
  const Rgb hole = colour_mapped(Image<float>(1, 1), {500.0, 600.0})(0, 0);
  const Image<Rgb> corner = picture_of(Image<float>(10, 10, 600.0f), {{-2, -2, 4, 4}, 1.0}, {500.0, 600.0});
  EXPECT_EQ(corner(1, 1), hole);
  EXPECT_FALSE(corner(2, 2) == hole);
  const Image<Rgb> empty = picture_of(Image<float>(), {{5, 5, 3, 3}, 2.0}, {500.0, 600.0});
  EXPECT_EQ(empty, Image<Rgb>(6, 6, hole));
  EXPECT_THAT(error_of([] { picture_of(Image<float>(), View{{}, 1.0}, {}); }), HasSubstr("crop"));
  for (const double scale : {0.0, -1.0, std::nan("")}) {
    EXPECT_THAT(error_of([&] {
                  picture_of(Image<float>(4, 4), View{{0, 0, 4, 4}, scale}, {});
                }),
                HasSubstr("a scale above 0"));
  }
}

TEST(Skeleton, IsDrawnAtTheJointsAndOnlyThere) {
  HandPose pose = HandPose::missing(convention_from_name("icg20"));
  pose.joints[0] = {10.0, 10.0, 500.0};  // palm
  pose.joints[4] = {20.0, 10.0, 500.0};  // index mcp, joined to the palm
  pose.joints[19] = {10.0, 20.0, kNaN};  // little tip, missing
  const View view{{0, 0, 30, 30}, 10.0};
  Image<Rgb> picture(300, 300);
  draw_skeleton(picture, pose, view, kEstimateColour);
  EXPECT_EQ(picture(105, 105), kEstimateColour);  // the centre of pixel 10, enlarged ten times
  EXPECT_EQ(picture(205, 105), kEstimateColour);
  EXPECT_EQ(picture(155, 105), kEstimateColour);  // on the bone
  EXPECT_EQ(picture(105, 205), Rgb{});
  EXPECT_EQ(picture(155, 155), Rgb{});
}

TEST(Skeleton, FarOutsideThePictureDoesNoHarm) {
  HandPose pose = HandPose::missing(convention_from_name("icg20"));
  for (ImagePoint& joint : pose.joints) joint = {1e9, -1e9, 500.0};
  pose.joints[0] = {5.0, 5.0, 500.0};
  Image<Rgb> picture(20, 20);
  draw_skeleton(picture, pose, {{0, 0, 10, 10}, 2.0}, kTruthColour);
  EXPECT_EQ(picture(10, 10), kTruthColour);
  const Image<Rgb> before = picture;
  draw_skeleton(picture, HandPose::missing(pose.convention), {{0, 0, 10, 10}, 2.0}, kTruthColour);
  EXPECT_EQ(picture, before);
}

TEST(Picture, OfAFrameEnlargesSmallImagesAndShowsTheTruth) {
  Frame frame;
  frame.depth_mm = Image<float>(160, 120, 700.0f);
  EXPECT_EQ(picture_of(frame).width(), 640);
  frame.truth = HandPose::missing(convention_from_name("icg20"));
  frame.truth->joints[0] = {80.0, 60.0, 700.0};
  EXPECT_EQ(picture_of(frame)(322, 242), kTruthColour);
}

TEST(HexCode, HasTwoLettersAChannel) {
  EXPECT_EQ(hex_code({0, 171, 255}), "#00abff");
}

}  // namespace
}  // namespace knuckle
