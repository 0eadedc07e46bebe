// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/map_operations.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

FeatureMap random_map(int height, int width, int channels, std::uint64_t seed) {
  FeatureMap map({height, width, channels, 1});
  Random random(seed);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      for (int i = 0; i < channels; ++i) {
        map.pixel(row, column)[i] = static_cast<float>(random.uniform(-1.0, 1.0));
      }
    }
  }
  return map;
}

TEST(AddTwiceAsLarge, GivesEachPixelFourTimes) {
  const FeatureMap coarse = random_map(3, 2, 11, 1);
  const FeatureMap before = random_map(6, 4, 11, 2);
  FeatureMap fine = before;
  add_twice_as_large(coarse, fine);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 4; ++column) {
      for (int i = 0; i < 11; ++i) {
        EXPECT_EQ(fine.pixel(row, column)[i],
                  before.pixel(row, column)[i] + coarse.pixel(row / 2, column / 2)[i]);
      }
    }
  }
}

TEST(MaxPool, IsTheLargestAndLeavesOutWhatIsLeftOver) {
  for (const int size : {1, 2, 4}) {
    const FeatureMap input = random_map(4 * size + size / 2, 3 * size + size / 2, 5, 3);
    FeatureMap output({4, 3, 5});
    max_pool(input, size, output);
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 3; ++column) {
        for (int i = 0; i < 5; ++i) {
          float largest = -2.0f;
          for (int y = 0; y < size; ++y) {
            for (int x = 0; x < size; ++x) {
              largest = std::max(largest, input.pixel(row * size + y, column * size + x)[i]);
            }
          }
          EXPECT_EQ(output.pixel(row, column)[i], largest);
        }
      }
    }
  }
}

TEST(Halve, IsTheMeanOfFour) {
  Image<float> image(8, 8);
  Random random(4);
  for (float& pixel : image.pixels()) pixel = static_cast<float>(random.uniform(-1.0, 1.0));
  FeatureMap whole = FeatureMap::of_image(8, 2);
  copy_image(image, whole);
  FeatureMap half = FeatureMap::of_image(4, 0);
  halve(whole, half);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double sum = static_cast<double>(image(2 * column, 2 * row)) + image(2 * column + 1, 2 * row) +
                         image(2 * column, 2 * row + 1) + image(2 * column + 1, 2 * row + 1);
      EXPECT_NEAR(half.pixel(row, column)[0], sum / 4.0, 1e-6);
    }
  }
  EXPECT_EQ(whole.pixel(-2, -2)[0], 0.0f);
  EXPECT_EQ(whole.pixel(3, 8)[0], 0.0f);
}

}  // namespace
}  // namespace knuckle
