// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/lateral_noise.h"

#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/synth/sensor/depth_edges.h"

namespace knuckle {
namespace {

constexpr int kRows = 4000;

Image<float> hand_then_nothing() {
  Image<float> image(8, kRows);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < 4; ++column) image(column, row) = 500.0f;
  }
  return image;
}

Image<float> with_lateral_noise(const Image<float>& image, double lateral_px, std::uint64_t seed = 1) {
  return displaced(image, displaced_pixels(edge_pixels(image, 20.0), image.width(), image.height(),
                                           {.lateral_px = lateral_px}, seed));
}

TEST(LateralNoise, MovesPixelsOverAStraightEdgeAsOftenAsANormalNumberPassesHalfAPixel) {
  for (const double lateral_px : {0.5, 0.8}) {
    const Image<float> image = with_lateral_noise(hand_then_nothing(), lateral_px);
    const double expected = 0.5 * std::erfc(0.5 / lateral_px / std::sqrt(2.0));
    int lost = 0;
    int gained = 0;
    for (int row = 0; row < kRows; ++row) {
      lost += image(3, row) == 0.0f ? 1 : 0;
      gained += image(4, row) != 0.0f ? 1 : 0;
      for (const int column : {0, 1, 2}) EXPECT_EQ(image(column, row), 500.0f);
      for (const int column : {5, 6, 7}) EXPECT_EQ(image(column, row), 0.0f);
    }
    EXPECT_NEAR(lost / double(kRows), expected, 0.025) << lateral_px;
    EXPECT_NEAR(gained / double(kRows), expected, 0.025) << lateral_px;
  }
}

TEST(LateralNoise, StaysInTheImageAndIsAFunctionOfSeedAndPlace) {
  Image<float> dots(9, 7);
  for (std::size_t i = 0; i < dots.size(); i += 2) dots.data()[i] = 600.0f;  // every pixel is beside an edge
  EXPECT_EQ(with_lateral_noise(dots, 2.0, 3), with_lateral_noise(dots, 2.0, 3));
  EXPECT_NE(with_lateral_noise(dots, 2.0, 3), with_lateral_noise(dots, 2.0, 4));
  EXPECT_EQ(with_lateral_noise(dots, 0.0), dots);
  const Image<float> plane(9, 7, 600.0f);
  EXPECT_EQ(with_lateral_noise(plane, 2.0), plane);
}

}  // namespace
}  // namespace knuckle
