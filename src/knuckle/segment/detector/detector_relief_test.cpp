// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_relief.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

constexpr DetectorOptions kPicture{.width = 48, .height = 32};

struct Picture {
  std::vector<float> inverse_depth = std::vector<float>(48 * 32);
  float& at(int column, int row) { return inverse_depth[static_cast<std::size_t>(row) * 48 + column]; }
  std::vector<float> reliefs() const {
    std::vector<float> reliefs(kReliefInputs * inverse_depth.size(), 7.0f);
    write_reliefs(kPicture, inverse_depth, reliefs);
    return reliefs;
  }
};

/// By the definition, cell by cell.
double relief_of(Picture& picture, int column, int row, int reach, double unit_mm) {
  const double own = picture.at(column, row);
  if (own == 0.0) return 0.0;
  double sum = 0.0;
  int count = 0;
  for (int v = std::max(0, row - reach); v <= std::min(31, row + reach); ++v) {
    for (int u = std::max(0, column - reach); u <= std::min(47, column + reach); ++u) {
      sum += picture.at(u, v);
      count += picture.at(u, v) > 0.0f ? 1 : 0;
    }
  }
  const double before_mm = 1000.0 / (sum / count) - 1000.0 / own;
  return before_mm / (unit_mm + std::abs(before_mm));
}

TEST(DetectorRelief, IsWhatTheDefinitionSays) {
  Random random(5);
  Picture picture;
  for (float& value : picture.inverse_depth) {
    value = random.uniform() < 0.3 ? 0.0f : static_cast<float>(random.uniform(0.3, 6.0));
  }
  const std::vector<float> reliefs = picture.reliefs();
  for (int row = 0; row < 32; ++row) {
    for (int column = 0; column < 48; ++column) {
      const std::size_t cell = static_cast<std::size_t>(row) * 48 + column;
      EXPECT_NEAR(reliefs[cell], relief_of(picture, column, row, 3, 10.0), 1e-4);
      EXPECT_NEAR(reliefs[48 * 32 + cell], relief_of(picture, column, row, 12, 40.0), 1e-4);
    }
  }
}

TEST(DetectorRelief, OfASlantedPlaneIsNothingAndOfWhatLiesOnItIsItsHeight) {
  Picture picture;
  for (int row = 0; row < 32; ++row) {
    for (int column = 0; column < 48; ++column) picture.at(column, row) = 1.2f + 0.01f * column - 0.02f * row;
  }
  EXPECT_NEAR(picture.reliefs()[16 * 48 + 24], 0.0, 1e-4);
  const float plane = picture.at(24, 16);
  picture.at(24, 16) = 1000.0f / (1000.0f / plane - 10.0f);  // 10 mm before it, alone among 49
  EXPECT_NEAR(picture.reliefs()[16 * 48 + 24], 0.5, 0.01) << "its height is the unit: a half";
}

TEST(DetectorRelief, IsFiniteWhateverWasMeasured) {
  Picture picture;
  picture.at(3, 3) = 1e-36f;
  picture.at(4, 3) = 10.0f;
  picture.at(40, 30) = 1e-36f;
  const std::vector<float> reliefs = picture.reliefs();
  EXPECT_TRUE(std::ranges::all_of(reliefs, [](float value) { return std::abs(value) <= 1.0f; }));
  EXPECT_EQ(reliefs[40 + 48 * 30], 0.0f) << "there is nothing near";
  EXPECT_EQ(reliefs[0], 0.0f) << "nothing was measured";
}

}  // namespace
}  // namespace knuckle
