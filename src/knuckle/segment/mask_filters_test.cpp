// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/mask_filters.h"

#include <tuple>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"

namespace knuckle::testing {
namespace {

Image<std::uint8_t> speckled(int width, int height, double share) {
  Random random(17, static_cast<std::uint64_t>(width * 1000 + height));
  Image<std::uint8_t> mask(width, height);
  for (std::uint8_t& pixel : mask.pixels()) pixel = random.uniform(0.0, 1.0) < share ? 1 : 0;
  return mask;
}

struct SquareCount {
  int set = 0;
  int in_image = 0;
};

SquareCount counted_plainly(const Image<std::uint8_t>& mask, int column, int row, int side) {
  SquareCount count;
  for (int y = row - side / 2; y <= row + side / 2; ++y) {
    for (int x = column - side / 2; x <= column + side / 2; ++x) {
      if (!mask.contains(x, y)) continue;
      count.in_image += 1;
      count.set += mask(x, y);
    }
  }
  return count;
}

/// Width, height, side: the square may be larger than the image.
class MaskFiltersTest : public ::testing::TestWithParam<std::tuple<int, int, int>> {};

TEST_P(MaskFiltersTest, AgreeWithCountingEachSquare) {
  const auto [width, height, side] = GetParam();
  for (const double share : {0.1, 0.5, 0.9}) {
    const Image<std::uint8_t> mask = speckled(width, height, share);
    const Image<std::uint16_t> sums = set_in_square(mask, side);
    const Image<std::uint8_t> median = majority(mask, side);
    const Image<std::uint8_t> larger = dilated(mask, side);
    const Image<std::uint8_t> smaller = eroded(mask, side);
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < width; ++column) {
        const SquareCount count = counted_plainly(mask, column, row, side);
        EXPECT_EQ(sums(column, row), count.set);
        EXPECT_EQ(median(column, row) != 0, 2 * count.set > side * side);
        EXPECT_EQ(larger(column, row) != 0, count.set > 0);
        EXPECT_EQ(smaller(column, row) != 0, count.set == count.in_image);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, MaskFiltersTest,
                         ::testing::Combine(::testing::Values(1, 7, 40), ::testing::Values(1, 5, 23),
                                            ::testing::Values(1, 3, 9, 31)));

TEST(MaskFilterLimits, TheLargestSquareIsCountedWhole) {
  const Image<std::uint8_t> mask(300, 300, 1);
  EXPECT_EQ(set_in_square(mask, 255)(150, 150), 255 * 255);
}

TEST(MaskFilterLimits, AnEmptyImageStaysEmpty) {
  EXPECT_TRUE(majority({}, 3).empty());
  EXPECT_TRUE(eroded({}, 3).empty());
}

}  // namespace
}  // namespace knuckle::testing
