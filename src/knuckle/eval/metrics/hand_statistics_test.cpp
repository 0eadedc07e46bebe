// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/hand_statistics.h"

#include <cmath>
#include <functional>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

constexpr Box kBox{20, 10, 100, 120};

/// A hand that fills columns [left(row), right(row)) of the box's rows, at 500 mm, before a wall at 700 mm.
struct Scene {
  Image<float> depth_mm{160, 140, 700.0f};
  Image<std::uint8_t> mask{kBox.width, kBox.height};

  explicit Scene(const std::function<double(int)>& left) {
    for (int row = kBox.y; row < kBox.bottom(); ++row) {
      for (int column = kBox.x; column < kBox.right() - 10; ++column) {
        if (column < left(row)) continue;
        depth_mm(column, row) = 500.0f;
        mask(column - kBox.x, row - kBox.y) = 1;
      }
    }
  }
  HandStatistics statistics() const { return hand_statistics(depth_mm, kBox, mask); }
};

TEST(HandStatistics, OfAFlatHandWithStraightOutlineAreNothing) {
  const HandStatistics statistics = Scene([](int) { return 40; }).statistics();
  EXPECT_EQ(statistics.depth_mm, 500.0);
  EXPECT_EQ(statistics.depth_spread_mm, 0.0);
  EXPECT_EQ(statistics.valid_share, 1.0);
  EXPECT_EQ(statistics.surface_noise_mm, 0.0);
  EXPECT_EQ(statistics.edge_noise_px, 0.0);
  EXPECT_EQ(statistics.flying_share, 0.0);
}

TEST(HandStatistics, SurfaceNoiseIsThatOfThePixels) {
  Scene scene([](int) { return 40; });
  Random random(1);
  for (float& depth : scene.depth_mm.pixels()) depth += static_cast<float>(2.0 * random.normal());
  const HandStatistics statistics = scene.statistics();
  EXPECT_NEAR(statistics.surface_noise_mm, 2.0, 0.06);
  EXPECT_NEAR(statistics.depth_spread_mm, 2.0, 0.06);
}

TEST(HandStatistics, ASlantIsSpreadButNotNoise) {
  Scene scene([](int) { return 40; });
  for (int row = 0; row < 140; ++row) {
    for (int column = 0; column < 160; ++column) scene.depth_mm(column, row) += 2.0f * row;
  }
  EXPECT_NEAR(scene.statistics().surface_noise_mm, 0.0, 1e-9);
  EXPECT_NEAR(scene.statistics().depth_spread_mm, 2.0 * 120 / std::sqrt(12.0), 0.5);
}

TEST(HandStatistics, EdgeNoiseIsThatOfTheOutline) {
  // Both outlines are counted: the left one is ragged, the right one straight.
  const Scene ragged([](int row) {
    Random random(3, static_cast<std::uint64_t>(row));
    return 40 + static_cast<int>(random.below(3));  // variance 2/3
  });
  EXPECT_NEAR(ragged.statistics().edge_noise_px, std::sqrt(0.5 * 2.0 / 3.0), 0.08);
  const Scene slanted([](int row) { return 40.0 + 0.37 * row; });
  EXPECT_LT(slanted.statistics().edge_noise_px, 0.3);
}

TEST(HandStatistics, FlyingPixelsAreCountedAmongThoseAtEdges) {
  Scene scene([](int) { return 40; });
  for (int row = kBox.y; row < kBox.bottom(); row += 4) scene.depth_mm(40, row) = 600.0f;
  // At each row four pixels are beside an edge, and every fourth row has a flying one.
  EXPECT_NEAR(scene.statistics().flying_share, 1.0 / 16.0, 0.02);
  // What is nearer, or farther, than both sides hangs nowhere between them.
  for (int row = kBox.y; row < kBox.bottom(); row += 4)
    scene.depth_mm(40, row) = row % 8 < 4 ? 450.0f : 750.0f;
  EXPECT_EQ(scene.statistics().flying_share, 0.0);
}

TEST(HandStatistics, HolesLowerTheValidShareAndMeansLeaveOutTheUnknown) {
  Scene scene([](int) { return 40; });
  for (int row = 0; row < 140; ++row) scene.depth_mm(25, row) = 0.0f;
  const HandStatistics statistics = scene.statistics();
  EXPECT_DOUBLE_EQ(statistics.valid_share, 0.99);
  HandStatistics other = statistics;
  other.valid_share = 0.5;
  other.flying_share = std::nan("");
  const HandStatistics both[] = {statistics, other};
  EXPECT_DOUBLE_EQ(mean_of(both).valid_share, 0.745);
  EXPECT_EQ(mean_of(both).flying_share, statistics.flying_share);
  EXPECT_TRUE(std::isnan(mean_of(std::span<const HandStatistics>{}).depth_mm));
}

}  // namespace
}  // namespace knuckle
