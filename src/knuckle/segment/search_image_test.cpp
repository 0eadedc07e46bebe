// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/search_image.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "knuckle/camera/projection.h"

namespace knuckle {
namespace {

TEST(SearchImage, StrideGrowsWithTheMeasuredPixelsAlone) {
  Image<float> depth(30, 20);
  EXPECT_EQ(search_stride(depth, 10), 1);
  for (int i = 0; i < 10; ++i) depth(3 * i, i) = 500.0f;
  EXPECT_EQ(search_stride(depth, 10), 1);
  depth(1, 19) = 500.0f;
  EXPECT_EQ(search_stride(depth, 10), 2);
  std::ranges::fill(depth.pixels(), 500.0f);  // 600 pixels: 600 / 8^2 < 10 < 600 / 7^2
  EXPECT_EQ(search_stride(depth, 10), 8);
  std::ranges::fill(depth.pixels(), std::numeric_limits<float>::infinity());
  EXPECT_EQ(search_stride(depth, 10), 1);
}

TEST(SearchImage, PixelsKeepTheirPlacesInTheWorld) {
  Camera camera{.width = 31, .height = 20, .fx = 40.0, .fy = -42.0, .cx = 14.0, .cy = 11.0};
  camera.distortion = {-0.2, 0.05, 0.001, -0.002, 0, 0, 0, 0};
  Image<float> depth(31, 20);
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 31; ++column)
      depth(column, row) = static_cast<float>(500 + 31 * row + column);
  }
  const Image<float> few = thinned(depth, 3);
  const Camera few_camera = thinned(camera, 3);
  ASSERT_EQ(few.width(), 11);
  ASSERT_EQ(few.height(), 7);
  EXPECT_EQ(few_camera.width, 11);
  EXPECT_EQ(few_camera.height, 7);
  EXPECT_EQ(few(10, 6), 500.0f + 31 * 18 + 30);
  const Point3 whole = Projection(camera).to_camera({24.0, 15.0, depth(24, 15)});
  const Point3 thin = Projection(few_camera).to_camera({8.0, 5.0, few(8, 5)});
  EXPECT_LT((whole - thin).norm(), 1e-6);
}

}  // namespace
}  // namespace knuckle
