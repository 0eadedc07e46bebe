// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/flying_pixels.h"

#include "knuckle/core/testing.h"
#include "knuckle/synth/sensor/depth_edges.h"

namespace knuckle {
namespace {

constexpr int kStepRows = 4000;
constexpr float kNear = 500.0f;
constexpr float kFar = 800.0f;

/// Near at the left, far at the right, the step between columns 3 and 4.
Image<float> near_then_far() {
  Image<float> image(8, kStepRows, kFar);
  for (int row = 0; row < kStepRows; ++row) {
    for (int column = 0; column < 4; ++column) image(column, row) = kNear;
  }
  return image;
}

Image<float> with_flying_pixels(const Image<float>& image, double flying_px, std::uint64_t seed = 1) {
  return with_flying_pixels(image, edge_pixels(image, 20.0), {.flying_px = flying_px}, seed);
}

TEST(FlyingPixels, MixTheExpectedPartOfTheEdgeAndNothingElse) {
  for (const double flying_px : {0.5, 1.0, 2.0}) {
    const Image<float> image = with_flying_pixels(near_then_far(), flying_px);
    int mixed[8] = {};
    for (int row = 0; row < kStepRows; ++row) {
      for (int column = 0; column < 8; ++column) {
        const float depth = image(column, row);
        if (depth == (column < 4 ? kNear : kFar)) continue;
        EXPECT_GT(depth, kNear);
        EXPECT_LT(depth, kFar);
        ++mixed[column];
      }
    }
    for (const int column : {0, 1, 2, 5, 6, 7}) EXPECT_EQ(mixed[column], 0) << column;
    EXPECT_NEAR(mixed[3], kStepRows * flying_px / 2, 150);
    EXPECT_NEAR(mixed[4], kStepRows * flying_px / 2, 150);
  }
}

TEST(FlyingPixels, LieWhereTheLightOfBothSurfacesPutsThem) {
  // Shares are uniform in (0, 1/2]: the mean depth of mixed near pixels is the mean of the mixture over them.
  double expected = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double share = 0.5 * (i + 0.5) / 10000;
    const double near_light = (1.0 - share) / (kNear * kNear);
    const double far_light = share / (kFar * kFar);
    expected += (kNear * near_light + kFar * far_light) / (near_light + far_light) / 10000;
  }
  const Image<float> image = with_flying_pixels(near_then_far(), 2.0);
  double mean = 0.0;
  for (int row = 0; row < kStepRows; ++row) mean += image(3, row) / kStepRows;
  EXPECT_NEAR(mean, expected, 2.0);  // three times its own deviation
}

TEST(FlyingPixels, APlaneHasNone) {
  Image<float> slanted(40, 30);
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 40; ++column) slanted(column, row) = 500.0f + 15.0f * column;
  }
  EXPECT_EQ(with_flying_pixels(slanted, 2.0), slanted);
}

TEST(FlyingPixels, NothingBehindGivesNoLight) {
  Image<float> image = near_then_far();
  for (float& depth : image.pixels()) depth = depth == kFar ? 0.0f : depth;
  EXPECT_EQ(with_flying_pixels(image, 2.0), image);
}

TEST(FlyingPixels, AreAFunctionOfSeedAndPlace) {
  EXPECT_EQ(with_flying_pixels(near_then_far(), 1.0, 4), with_flying_pixels(near_then_far(), 1.0, 4));
  EXPECT_NE(with_flying_pixels(near_then_far(), 1.0, 4), with_flying_pixels(near_then_far(), 1.0, 5));
  EXPECT_EQ(with_flying_pixels(near_then_far(), 0.0), near_then_far());
}

}  // namespace
}  // namespace knuckle
