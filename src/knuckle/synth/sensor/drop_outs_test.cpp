// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/drop_outs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(DropOuts, AGrazingSurfaceIsLostAboveTheAngleOnly) {
  Image<float> depths(90, 1, 500.0f);
  Image<float> cosines(90, 1);
  for (int degree = 0; degree < 90; ++degree) {
    cosines(degree, 0) = static_cast<float>(std::cos((degree + 0.5) * std::numbers::pi / 180.0));
  }
  const Image<float> left = with_drop_outs(depths, cosines, {.grazing_deg = 70.0}, 1);
  for (int degree = 0; degree < 90; ++degree) EXPECT_EQ(left(degree, 0) == 0.0f, degree >= 70) << degree;
  EXPECT_EQ(with_drop_outs(depths, cosines, {}, 1), depths);
  EXPECT_EQ(with_drop_outs(depths, {}, {.grazing_deg = 10.0}, 1), depths);  // all surfaces face the camera
}

TEST(DropOuts, NothingIsMeasuredOutsideTheRange) {
  Image<float> depths(5, 1);
  for (int i = 0; i < 5; ++i) depths(i, 0) = 100.0f * static_cast<float>(i) - 100.0f;  // -100 to 300
  const Image<float> limited = with_drop_outs(depths, {}, {.near_mm = 150.0, .range_mm = 250.0}, 1);
  EXPECT_EQ(limited(3, 0), 200.0f);
  for (const int i : {0, 1, 2, 4}) EXPECT_EQ(limited(i, 0), 0.0f) << i;
  const Image<float> unlimited = with_drop_outs(depths, {}, {}, 1);
  EXPECT_EQ(unlimited(0, 0), 0.0f);  // behind the camera
  EXPECT_EQ(unlimited(4, 0), 300.0f);
}

TEST(DropOuts, HolesTakeTheirShareAndNoMore) {
  const Image<float> plane(400, 300, 500.0f);
  const Image<float> holed = with_drop_outs(plane, {}, {.hole_share = 0.05}, 3);
  const auto lost = std::ranges::count(holed.pixels(), 0.0f);
  EXPECT_NEAR(lost / 120000.0, 0.05, 0.003);  // five times its deviation
  EXPECT_EQ(holed, with_drop_outs(plane, {}, {.hole_share = 0.05}, 3));
  EXPECT_NE(holed, with_drop_outs(plane, {}, {.hole_share = 0.05}, 4));
  const Image<float> nothing = with_drop_outs(plane, {}, {.hole_share = 1.0}, 3);
  EXPECT_EQ(std::ranges::max(nothing.pixels()), 0.0f);
}

}  // namespace
}  // namespace knuckle
