// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor_noise.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(SensorNoise, HasTheDeviationAskedForAndNoBias) {
  const Image<float> plane(400, 300, 700.0f);
  const Image<float> noisy = measured(plane, {.sigma_mm = 3.0, .quantisation_mm = 0.0}, 5);
  double sum = 0.0;
  double sum_of_squares = 0.0;
  double beyond_two = 0.0;
  for (const float depth : noisy.pixels()) {
    const double error = depth - 700.0;
    sum += error;
    sum_of_squares += error * error;
    beyond_two += std::abs(error) > 6.0 ? 1.0 : 0.0;
  }
  const auto count = static_cast<double>(noisy.size());
  EXPECT_NEAR(sum / count, 0.0, 0.04);  // four and a half times its own deviation
  EXPECT_NEAR(std::sqrt(sum_of_squares / count), 3.0, 0.03);
  EXPECT_NEAR(beyond_two / count, 0.0455, 0.003);
}

TEST(SensorNoise, NeighboursAreIndependent) {
  const Image<float> noisy = measured(Image<float>(400, 300, 700.0f), {.quantisation_mm = 0.0}, 6);
  double right = 0.0;
  double below = 0.0;
  for (int row = 0; row + 1 < 300; ++row) {
    for (int column = 0; column + 1 < 400; ++column) {
      const double here = noisy(column, row) - 700.0;
      right += here * (noisy(column + 1, row) - 700.0);
      below += here * (noisy(column, row + 1) - 700.0);
    }
  }
  EXPECT_NEAR(right / (399 * 299), 0.0, 0.13);
  EXPECT_NEAR(below / (399 * 299), 0.0, 0.13);
}

TEST(SensorNoise, IsAFunctionOfSeedAndPlace) {
  Image<float> image(50, 40, 500.0f);
  const Image<float> all = measured(image, {}, 9);
  EXPECT_EQ(all, measured(image, {}, 9));
  EXPECT_NE(all, measured(image, {}, 10));
  for (int i = 0; i < 1000; ++i) image.data()[i] = 0.0f;  // what is missing elsewhere changes nothing here
  const Image<float> part = measured(image, {}, 9);
  for (int i = 1000; i < 2000; ++i) EXPECT_EQ(all.data()[i], part.data()[i]);
}

TEST(SensorNoise, LeavesTheUnmeasuredAlone) {
  const Image<float> nothing(33, 7);
  EXPECT_EQ(measured(nothing, {}, 1), nothing);
}

TEST(SensorNoise, RoundsToWholeSteps) {
  const Image<float> rounded =
      measured(Image<float>(64, 48, 433.3f), {.sigma_mm = 5.0, .quantisation_mm = 2.5}, 3);
  for (const float depth : rounded.pixels()) EXPECT_EQ(depth, std::nearbyint(depth / 2.5f) * 2.5f);
}

TEST(SensorNoise, OffIsExact) {
  const Image<float> exact(20, 20, 433.3f);
  EXPECT_EQ(measured(exact, {.sigma_mm = 0.0, .quantisation_mm = 0.0}, 3), exact);
}

TEST(SensorNoise, AWallHidesWhatLiesBehindItAndFillsTheRest) {
  Image<float> image(4, 1);
  image(0, 0) = 500.0f;
  image(1, 0) = 900.0f;
  const Image<float> walled = measured(image, {.sigma_mm = 0.0, .background_mm = 800.0}, 1);
  EXPECT_EQ(walled(0, 0), 500.0f);
  EXPECT_EQ(walled(1, 0), 800.0f);
  EXPECT_EQ(walled(2, 0), 800.0f);
}

TEST(SensorNoise, NothingIsMeasuredBeyondTheRangeOrBehindTheCamera) {
  Image<float> image(2, 1);
  image(0, 0) = 500.0f;
  image(1, 0) = 900.0f;
  EXPECT_EQ(measured(image, {.sigma_mm = 0.0, .range_mm = 800.0}, 1)(1, 0), 0.0f);
  const Image<float> near = measured(Image<float>(50, 50, 2.0f), {.sigma_mm = 50.0}, 1);
  EXPECT_GE(std::ranges::min(near.pixels()), 0.0f);
}

TEST(SensorNoise, RefusesImpossibleOptions) {
  EXPECT_THAT(testing::error_of([] { measured(Image<float>(2, 2), {.sigma_mm = -1.0}, 1); }),
              ::testing::HasSubstr("sigma_mm"));
}

}  // namespace
}  // namespace knuckle
