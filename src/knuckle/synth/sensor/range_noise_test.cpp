// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/range_noise.h"

#include <cmath>
#include <numbers>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

struct Errors {
  double mean = 0.0;
  double deviation = 0.0;
  double beyond_two = 0.0;  ///< share of errors of more than two deviations
};

Errors errors_on_plane(float depth_mm, double cosine, const RangeNoiseOptions& options) {
  const Image<float> plane(400, 300, depth_mm);
  const Image<float> cosines(400, 300, static_cast<float>(cosine));
  const Image<float> noisy = with_range_noise(plane, cosines, options, 5);
  const double sigma = range_sigma_mm(options, depth_mm, cosine);
  Errors errors;
  double squares = 0.0;
  for (const float depth : noisy.pixels()) {
    const double error = depth - depth_mm;
    errors.mean += error / noisy.size();
    squares += error * error / noisy.size();
    errors.beyond_two += (std::abs(error) > 2.0 * sigma ? 1.0 : 0.0) / noisy.size();
  }
  errors.deviation = std::sqrt(squares);
  return errors;
}

TEST(RangeNoise, IsNormalWithTheDeviationAskedForAndNoBias) {
  const Errors errors = errors_on_plane(700.0f, 1.0, {.sigma_mm = 3.0});
  EXPECT_NEAR(errors.mean, 0.0, 0.04);  // four and a half times its own deviation
  EXPECT_NEAR(errors.deviation, 3.0, 0.03);
  EXPECT_NEAR(errors.beyond_two, 0.0455, 0.003);
}

TEST(RangeNoise, GrowsWithTheSquareOfTheRange) {
  const RangeNoiseOptions options{.sigma_mm = 0.0, .growth_mm = 2.0};
  EXPECT_NEAR(errors_on_plane(500.0f, 1.0, options).deviation, 0.5, 0.005);
  EXPECT_NEAR(errors_on_plane(1000.0f, 1.0, options).deviation, 2.0, 0.02);
  EXPECT_NEAR(errors_on_plane(2000.0f, 1.0, options).deviation, 8.0, 0.08);
}

TEST(RangeNoise, GrowsWithTheAngle) {
  const RangeNoiseOptions options{.sigma_mm = 1.0, .slant_mm = 0.5};
  for (const double degrees : {0.0, 30.0, 45.0, 60.0, 75.0}) {
    const double theta = degrees * std::numbers::pi / 180.0;
    const double expected = 1.0 + 0.5 * std::pow(degrees / (90.0 - degrees), 2);
    EXPECT_NEAR(range_sigma_mm(options, 500.0, std::cos(theta)), expected, 1e-6) << degrees;
    EXPECT_NEAR(errors_on_plane(500.0f, std::cos(theta), options).deviation, expected, 0.015 * expected)
        << degrees;
  }
  EXPECT_EQ(range_sigma_mm(options, 500.0, 0.0), range_sigma_mm(options, 500.0, 0.01));  // bounded
}

TEST(RangeNoise, NeighboursAreIndependent) {
  const Image<float> noisy = with_range_noise(Image<float>(400, 300, 700.0f), {}, {.sigma_mm = 3.0}, 6);
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

/// Mean product of the errors of pixels `distance` apart in a row, over many frames.
double covariance(const RangeNoiseOptions& options, int distance) {
  double sum = 0.0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const Image<float> noisy = with_range_noise(Image<float>(50, 9, 700.0f), {}, options, seed);
    for (int row = 0; row < 9; ++row) {
      for (int column = 0; column + distance < 50; ++column) {
        sum += (noisy(column, row) - 700.0) * (noisy(column + distance, row) - 700.0);
        ++count;
      }
    }
  }
  return sum / count;
}

TEST(RangeNoise, AGrainIsSharedByNeighboursOnly) {
  const RangeNoiseOptions options{.sigma_mm = 3.0, .grain_px = 4};
  EXPECT_NEAR(covariance(options, 0), 9.0, 0.3);
  EXPECT_GT(covariance(options, 1), 0.85 * 9.0);
  EXPECT_LT(covariance(options, 4), 0.5 * 9.0);
  EXPECT_NEAR(covariance(options, 8), 0.0, 0.3);
}

TEST(RangeNoise, AGrainKeepsTheDeviationAtEveryPixel) {
  const RangeNoiseOptions options{.sigma_mm = 2.0, .grain_px = 3};
  Image<double> squares(14, 7);
  constexpr int kFrames = 4000;
  for (std::uint64_t seed = 0; seed < kFrames; ++seed) {
    const Image<float> noisy = with_range_noise(Image<float>(14, 7, 500.0f), {}, options, seed);
    for (std::size_t i = 0; i < squares.size(); ++i) {
      squares.data()[i] += std::pow(noisy.data()[i] - 500.0, 2) / kFrames;
    }
  }
  for (const double square : squares.pixels()) EXPECT_NEAR(std::sqrt(square), 2.0, 0.1);
}

TEST(RangeNoise, IsAFunctionOfSeedAndPlace) {
  Image<float> image(51, 40, 500.0f);
  const Image<float> all = with_range_noise(image, {}, {}, 9);
  EXPECT_EQ(all, with_range_noise(image, {}, {}, 9));
  EXPECT_NE(all, with_range_noise(image, {}, {}, 10));
  for (int i = 0; i < 1000; ++i) image.data()[i] = 0.0f;  // what is missing elsewhere changes nothing here
  const Image<float> part = with_range_noise(image, {}, {}, 9);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(part.data()[i], 0.0f);
  for (int i = 1000; i < 2040; ++i) EXPECT_EQ(all.data()[i], part.data()[i]);
}

TEST(RangeNoise, AGrainIsAFunctionOfSeedAndPlaceToo) {
  const RangeNoiseOptions options{.grain_px = 5};
  Image<float> image(51, 40, 500.0f);
  const Image<float> all = with_range_noise(image, {}, options, 9);
  EXPECT_NE(all, with_range_noise(image, {}, options, 10));
  for (int i = 0; i < 1020; ++i) image.data()[i] = 0.0f;
  const Image<float> part = with_range_noise(image, {}, options, 9);
  for (int i = 0; i < 1020; ++i) EXPECT_EQ(part.data()[i], 0.0f);
  for (int i = 1020; i < 2040; ++i) EXPECT_EQ(all.data()[i], part.data()[i]);
}

TEST(RangeNoise, OffIsExact) {
  const Image<float> exact(20, 20, 433.3f);
  EXPECT_EQ(with_range_noise(exact, {}, {.sigma_mm = 0.0}, 3), exact);
}

}  // namespace
}  // namespace knuckle
