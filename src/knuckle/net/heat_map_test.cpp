// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/heat_map.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"
#include "knuckle/patch/cube_patch.h"

namespace knuckle {
namespace {

constexpr int kMapCells = 18;
constexpr double kMapPxPerCell = 96.0 / kMapCells;

std::vector<float> gaussian_map(double column, double row, double deviation, double noise = 0.0) {
  std::vector<float> map;
  Random random(1);
  for (int y = 0; y < kMapCells; ++y) {
    for (int x = 0; x < kMapCells; ++x) {
      const double squared = (x - column) * (x - column) + (y - row) * (y - row);
      map.push_back(
          static_cast<float>(std::exp(-0.5 * squared / (deviation * deviation)) + noise * random.normal()));
    }
  }
  return map;
}

TEST(HeatMapGrid, PlacesAreTheSameThereAndBack) {
  const HeatMapGrid grid{kMapCells, 96};
  for (const double cell : {-1.0, 0.0, 3.3, 17.0})
    EXPECT_NEAR(grid.cell_of(grid.coordinate_of(cell)), cell, 1e-12);
  EXPECT_NEAR(grid.coordinate_of(0.5 * (kMapCells - 1)), 0.0, 1e-12) << "the middle is the middle";
  EXPECT_NEAR(grid.cell_of(-1.0), (0.5 / kMapPxPerCell) - 0.5, 1e-12)
      << "the first pixel lies in the first cell";
}

TEST(GaussianPeak, FindsAKnownGaussianToAFiftiethOfAPatchPixel) {
  for (const double deviation : {0.8, 1.0, 1.7}) {
    for (const double column : {0.0, 0.4, 5.25, 8.5, 16.9, 17.0}) {
      for (const double row : {0.0, 3.0, 9.49, 17.3}) {
        const HeatMapPeak peak = gaussian_peak(gaussian_map(column, row, deviation), kMapCells);
        EXPECT_LT(std::hypot(peak.column - column, peak.row - row) * kMapPxPerCell, 0.02)
            << column << ", " << row << ", " << deviation;
      }
    }
  }
}

TEST(GaussianPeak, BearsNoise) {
  double squares = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double column = 5.0 + 0.07 * i;
    const HeatMapPeak peak = gaussian_peak(gaussian_map(column, 7.3, 1.0, 0.02), kMapCells);
    squares += std::pow(peak.column - column, 2) + std::pow(peak.row - 7.3, 2);
  }
  EXPECT_LT(std::sqrt(squares / 100.0), 0.1);
}

TEST(GaussianPeak, OfAMapWithoutAPeakIsTheLargestCell) {
  std::vector<float> map(kMapCells * kMapCells, 0.0f);
  map[3 * kMapCells + 5] = -0.0f;
  EXPECT_EQ(gaussian_peak(map, kMapCells).value, 0.0f);
  map.assign(map.size(), -1.0f);
  map[3 * kMapCells + 5] = -0.5f;
  const HeatMapPeak negative = gaussian_peak(map, kMapCells);
  EXPECT_EQ(negative.column, 5.0);
  EXPECT_EQ(negative.row, 3.0);
  map[3 * kMapCells + 5] = 2.0f;
  const HeatMapPeak alone = gaussian_peak(map, kMapCells);
  EXPECT_EQ(alone.column, 5.0);
  EXPECT_EQ(alone.row, 3.0);
  map.assign(map.size(), 1.0f);
  const HeatMapPeak flat = gaussian_peak(map, kMapCells);
  EXPECT_TRUE(flat.column >= 0.0 && flat.column <= 1.0 && std::isfinite(flat.row));
}

TEST(MeanShiftPeak, FindsAGaussianInsideTheMap) {
  for (const double column : {5.0, 5.25, 8.5, 11.9}) {
    const HeatMapPeak peak = mean_shift_peak(gaussian_map(column, 9.4, 1.0), kMapCells, 1.0);
    EXPECT_NEAR(peak.column, column, 0.01);
    EXPECT_NEAR(peak.row, 9.4, 0.01);
  }
}

TEST(MeanShiftPeak, StaysAtTheLargerOfTwoPeaks) {
  std::vector<float> map = gaussian_map(4.0, 4.0, 1.0);
  const std::vector<float> smaller = gaussian_map(13.0, 13.0, 1.0);
  for (std::size_t i = 0; i < map.size(); ++i) map[i] += 0.7f * smaller[i];
  EXPECT_NEAR(mean_shift_peak(map, kMapCells, 1.0).column, 4.0, 0.01);
  EXPECT_EQ(mean_shift_peak(std::vector<float>(kMapCells * kMapCells, -1.0f), kMapCells, 1.0).column, 0.0);
}

TEST(SoftArgMax, FindsAKnownGaussian) {
  for (const double centre : {3.0, 7.3, 12.5, 20.9}) {
    std::vector<float> bins;
    for (int i = 0; i < 25; ++i)
      bins.push_back(static_cast<float>(std::exp(-0.5 * (i - centre) * (i - centre))));
    EXPECT_NEAR(soft_arg_max(bins), centre, 0.05) << centre;
  }
  EXPECT_EQ(soft_arg_max(std::vector<float>{1.0f, 0.5f, 0.0f}), 0.0) << "the border has one side only";
  EXPECT_EQ(soft_arg_max(std::vector<float>{0.0f, 0.5f, 1.0f}), 2.0) << "and so has the other one";
  EXPECT_NEAR(soft_arg_max(std::vector<float>{9.0f, 0.0f, 0.0f, 0.2f, 10.0f, 0.1f}),
              (0.6 + 40.0 + 0.5) / 10.3, 1e-6);
  EXPECT_EQ(soft_arg_max(std::vector<float>{-2.0f, -1.0f, -3.0f}), 1.0);
}

TEST(SurfaceDepth, IsTheMedianOfThePixelsAroundThatShowTheHand) {
  std::vector<float> patch(20 * 20, kCubeBackground);
  const auto at = [](int pixel) { return pixel / 9.5 - 1.0; };
  EXPECT_EQ(surface_depth(patch, 20, 0.0, 0.0), 0.0f) << "no hand";
  patch[2 * 20 + 3] = -0.4f;
  patch[2 * 20 + 4] = 0.1f;
  patch[3 * 20 + 4] = 0.2f;
  EXPECT_FLOAT_EQ(surface_depth(patch, 20, at(4), at(3)), 0.1f) << "all three";
  EXPECT_FLOAT_EQ(surface_depth(patch, 20, at(1), at(2)), -0.4f) << "only the first is near enough";
  EXPECT_FLOAT_EQ(surface_depth(patch, 20, at(4), at(9)), 0.2f) << "none is: the nearest";
  EXPECT_FLOAT_EQ(surface_depth(patch, 20, at(19), at(19)), 0.2f);
  EXPECT_FLOAT_EQ(surface_depth(patch, 20, -7.0, 5.0), 0.2f) << "outside of the patch";
}

}  // namespace
}  // namespace knuckle
