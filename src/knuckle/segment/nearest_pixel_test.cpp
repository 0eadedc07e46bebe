// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/nearest_pixel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "knuckle/core/frame.h"
#include "knuckle/core/random.h"

namespace knuckle {
namespace {

/// The whole filter, written as its definition reads: the lower median of the measured pixels, 0 below 13 of
/// them.
Image<float> filtered(const Image<float>& depth_mm) {
  Image<float> result(depth_mm.width(), depth_mm.height());
  for (int row = 0; row < depth_mm.height(); ++row) {
    for (int column = 0; column < depth_mm.width(); ++column) {
      std::vector<float> values;
      for (int j = row - 2; j <= row + 2; ++j) {
        for (int i = column - 2; i <= column + 2; ++i) {
          if (depth_mm.contains(i, j) && is_measured(depth_mm(i, j))) values.push_back(depth_mm(i, j));
        }
      }
      std::ranges::sort(values);
      if (values.size() >= 13) result(column, row) = values[(values.size() - 1) / 2];
    }
  }
  return result;
}

float smallest_measured(const Image<float>& depth_mm) {
  float smallest = std::numeric_limits<float>::infinity();
  for (const float depth : depth_mm.pixels()) {
    if (is_measured(depth)) smallest = std::min(smallest, depth);
  }
  return smallest;
}

Image<float> noisy_surface(std::uint64_t seed, double measured_share) {
  Random random(seed);
  Image<float> depth(20 + static_cast<int>(random.below(60)), 20 + static_cast<int>(random.below(40)));
  const double slope_x = random.uniform(-2, 2);
  const double slope_y = random.uniform(-2, 2);
  for (int row = 0; row < depth.height(); ++row) {
    for (int column = 0; column < depth.width(); ++column) {
      if (random.uniform() > measured_share) continue;
      const double surface = 700 + slope_x * column + slope_y * row + 10 * random.normal();
      depth(column, row) = static_cast<float>(random.uniform() < 0.05 ? 50.0 : surface);
    }
  }
  return depth;
}

TEST(NearestPixel, HasTheDepthOfTheFullyFilteredImage) {
  for (const double measured_share : {0.3, 0.5, 0.6, 0.9, 1.0}) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const Image<float> depth = noisy_surface(seed, measured_share);
      const Image<float> median = filtered(depth);
      const float smallest = smallest_measured(median);
      const std::optional<NearestPixel> nearest = nearest_pixel(depth);
      ASSERT_EQ(nearest.has_value(), std::isfinite(smallest)) << seed;
      if (!nearest) continue;
      EXPECT_EQ(nearest->depth_mm, smallest) << seed;
      EXPECT_EQ(median(nearest->column, nearest->row), smallest) << seed;
      EXPECT_EQ(median_depth(depth, nearest->column, nearest->row), smallest);
    }
  }
}

TEST(NearestPixel, IgnoresStrayPixelsInFrontOfASurface) {
  Image<float> depth(40, 30, 600.0f);
  depth(7, 9) = 100.0f;
  depth(8, 9) = 100.0f;
  depth(39, 29) = 50.0f;
  EXPECT_EQ(nearest_pixel(depth)->depth_mm, 600.0f);
}

TEST(NearestPixel, IgnoresStrayPixelsInEmptySpace) {
  Image<float> depth(40, 30);
  depth(7, 9) = 100.0f;
  for (int row = 15; row < 20; ++row) {
    for (int column = 15; column < 20; ++column) depth(column, row) = 500.0f;
  }
  EXPECT_EQ(nearest_pixel(depth)->depth_mm, 500.0f);
}

TEST(NearestPixel, AMedianNeedsMoreThanHalfOfItsWindow) {
  Image<float> depth(40, 30);
  for (int i = 0; i < 12; ++i) depth(18 + i % 5, 12 + i / 5) = 500.0f;
  EXPECT_EQ(median_depth(depth, 20, 14), 0.0f) << "12 of 25 are measured";
  EXPECT_FALSE(nearest_pixel(depth));
  depth(20, 14) = 480.0f;
  EXPECT_EQ(median_depth(depth, 20, 14), 500.0f);
  ASSERT_TRUE(nearest_pixel(depth));
  EXPECT_EQ(nearest_pixel(depth)->depth_mm, 500.0f);
}

TEST(NearestPixel, ARowOfManyCandidatesIsSearchedLikeOthers) {
  // A noisy wall with holes: most windows have some pixels below any bound.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Image<float> depth(200, 60);
    for (float& pixel : depth.pixels()) {
      const double noisy = std::round(600.0 + 4.0 * random.normal());
      pixel = random.uniform() < 0.2 ? 0.0f : static_cast<float>(noisy);
    }
    const std::optional<NearestPixel> nearest = nearest_pixel(depth);
    ASSERT_TRUE(nearest);
    EXPECT_EQ(nearest->depth_mm, smallest_measured(filtered(depth)));
  }
}

TEST(NearestPixel, TakesNotANumberInfinityAndNegativesForNoMeasurement) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(), -100.0f, 0.0f}) {
    Image<float> depth(32, 32, bad);
    EXPECT_FALSE(nearest_pixel(depth)) << bad;
    for (int row = 10; row < 20; ++row) {
      for (int column = 10; column < 20; ++column) depth(column, row) = 400.0f;
    }
    ASSERT_TRUE(nearest_pixel(depth)) << bad;
    EXPECT_EQ(nearest_pixel(depth)->depth_mm, 400.0f) << bad;
  }
}

TEST(NearestPixel, FindsNothingInEmptyAndTinyImages) {
  EXPECT_FALSE(nearest_pixel(Image<float>()));
  EXPECT_FALSE(nearest_pixel(Image<float>(3, 4, 500.0f)));  // 12 pixels
  EXPECT_TRUE(nearest_pixel(Image<float>(1, 200, 500.0f)) == std::nullopt);
  EXPECT_TRUE(nearest_pixel(Image<float>(4, 4, 500.0f)));
}

}  // namespace
}  // namespace knuckle
