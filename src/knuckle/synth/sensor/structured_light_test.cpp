// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/structured_light.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

constexpr double kJump = 20.0;
const Camera kWideCamera{.width = 400, .height = 3, .fx = 580, .fy = 580, .cx = 199.5, .cy = 1};

/// A wall with a strip before it, in columns [first, last].
Image<float> strip(float near_mm, float far_mm, int first, int last) {
  Image<float> image(kWideCamera.width, kWideCamera.height, far_mm);
  for (int row = 0; row < image.height(); ++row) {
    for (int column = first; column <= last; ++column) image(column, row) = near_mm;
  }
  return image;
}

/// Columns of the middle row that lie in the shadow.
std::vector<int> dark_columns(const Image<float>& image, double baseline_mm) {
  const Image<float> lit = without_shadows(image, kWideCamera, {.baseline_mm = baseline_mm}, kJump);
  std::vector<int> dark;
  for (int column = 0; column < image.width(); ++column) {
    if (lit(column, 1) == 0.0f && image(column, 1) != 0.0f) dark.push_back(column);
  }
  return dark;
}

TEST(StructuredLight, AShadowIsAsWideAsTheDifferenceOfDisparities) {
  for (const auto& [near_mm, far_mm] : {std::pair{500.0f, 700.0f}, {600.0f, 1500.0f}, {900.0f, 1000.0f}}) {
    const double width = 580 * 75.0 * (1 / near_mm - 1 / far_mm);
    const std::vector<int> left = dark_columns(strip(near_mm, far_mm, 200, 320), 75.0);
    ASSERT_FALSE(left.empty());
    EXPECT_NEAR(left.size(), width, 1.5);
    EXPECT_EQ(left.back(), 199);  // beside the strip, away from the projector
    EXPECT_EQ(left.back() - left.front() + 1, int(left.size()));
    const std::vector<int> right = dark_columns(strip(near_mm, far_mm, 100, 220), -75.0);
    ASSERT_FALSE(right.empty());
    EXPECT_NEAR(right.size(), width, 1.5);
    EXPECT_EQ(right.front(), 221);
  }
}

TEST(StructuredLight, AThinThingThrowsItsShadowBesideItself) {
  // 10 px wide, and displaced by 36 px: the wall between thing and shadow is lit from the other side.
  const std::vector<int> dark = dark_columns(strip(500.0f, 850.0f, 200, 209), 75.0);
  EXPECT_NEAR(dark.size(), 10.0, 1.5);
  EXPECT_NEAR(dark.front(), 200 - 580 * 75.0 * (1 / 500.0 - 1 / 850.0), 1.5);
}

TEST(StructuredLight, ASurfaceThatTheProjectorSeesIsLit) {
  EXPECT_TRUE(dark_columns(Image<float>(kWideCamera.width, kWideCamera.height, 600.0f), 75.0).empty());
  Image<float> slanted(kWideCamera.width, kWideCamera.height);
  for (int row = 0; row < slanted.height(); ++row) {
    for (int column = 0; column < slanted.width(); ++column) slanted(column, row) = 500.0f + 2.0f * column;
  }
  EXPECT_TRUE(dark_columns(slanted, 75.0).empty());
  EXPECT_TRUE(dark_columns(slanted, -75.0).empty());
  const Image<float> step = strip(500.0f, 800.0f, 100, 200);
  EXPECT_EQ(without_shadows(step, kWideCamera, {.baseline_mm = 75, .shadows = false}, kJump), step);
  EXPECT_EQ(without_shadows(step, kWideCamera, {}, kJump), step);
}

TEST(StructuredLight, DisparitiesAreWholeNumbersOfSteps) {
  const StructuredLightOptions options{.baseline_mm = 75.0, .disparity_px = 0.125};
  Image<float> depths(kWideCamera.width, kWideCamera.height);
  for (std::size_t i = 0; i < depths.size(); ++i) depths.data()[i] = 400.0f + 3.1f * static_cast<float>(i);
  const Image<float> rounded = with_rounded_disparity(depths, kWideCamera, options);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const double steps = 580 * 75.0 / 0.125 / rounded.data()[i];
    EXPECT_NEAR(steps, std::nearbyint(steps), 1e-3);
    const double depth = depths.data()[i];
    EXPECT_NEAR(rounded.data()[i], depth, 0.51 * depth * depth / (580 * 75.0 * 8));
  }
}

TEST(StructuredLight, DepthStepsAreThoseOfKhoshelham) {
  // 2.85e-5 z^2 cm at z cm: 2.9 mm at 1 m, 7 cm at 5 m.
  const Camera camera{.width = 2000, .height = 1, .fx = 585, .fy = 585};
  const StructuredLightOptions options{.baseline_mm = 75.0, .disparity_px = 0.125};
  for (const double range_mm : {1000.0, 3000.0, 5000.0}) {
    Image<float> depths(2000, 1);
    for (int i = 0; i < 2000; ++i) depths(i, 0) = static_cast<float>(range_mm * (1.0 + 1e-4 * (i - 1000)));
    const Image<float> rounded = with_rounded_disparity(depths, camera, options);
    const std::set<float> steps(rounded.pixels().begin(), rounded.pixels().end());
    const auto above = steps.lower_bound(static_cast<float>(range_mm));
    ASSERT_NE(above, steps.begin());
    EXPECT_NEAR(*above - *std::prev(above), 2.85e-6 * range_mm * range_mm,
                0.02 * range_mm * range_mm * 1e-6 * 5);
  }
}

TEST(StructuredLight, WhatIsNotSeenStaysSo) {
  const Image<float> nothing(kWideCamera.width, kWideCamera.height);
  EXPECT_EQ(without_shadows(nothing, kWideCamera, {.baseline_mm = 75}, kJump), nothing);
  EXPECT_EQ(with_rounded_disparity(nothing, kWideCamera, {.baseline_mm = 75, .disparity_px = 1}), nothing);
}

}  // namespace
}  // namespace knuckle
