// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/window_matching.h"

#include <array>
#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

Image<float> wall(float depth_mm) {
  return Image<float>(40, 30, depth_mm);
}

/// The left half is nearer.
Image<float> step() {
  Image<float> image = wall(800);
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 20; ++column) image(column, row) = 500;
  }
  return image;
}

TEST(WindowMatching, OffItChangesNothing) {
  EXPECT_EQ(matched_in_windows(wall(500), {}, 20, 1), wall(500));
  EXPECT_EQ(matched_in_windows(wall(500), {.window_px = 3, .window_share = 0}, 20, 1), wall(500));
}

TEST(WindowMatching, APlaneIsItselfAndRoughnessIsAveraged) {
  const Image<float> plane = matched_in_windows(wall(500), {.window_px = 3}, 20, 1);
  for (const float depth : plane.pixels()) EXPECT_NEAR(depth, 500.0f, 1e-3f);
  Image<float> rough = wall(500);
  for (int i = 0; i < 40 * 30; ++i) rough.data()[i] += i % 2 == 0 ? 5.0f : -5.0f;
  const Image<float> smooth = matched_in_windows(rough, {.window_px = 3}, 20, 1);
  for (int row = 4; row < 26; ++row) {
    for (int column = 4; column < 36; ++column) {
      // Seven columns: three like the middle one, four like its neighbours; means are of 1 / z.
      const double own = column % 2 == 0 ? 505.0 : 495.0;
      EXPECT_NEAR(smooth(column, row), 7.0 / (3.0 / own + 4.0 / (1000.0 - own)), 1e-2);
    }
  }
}

TEST(WindowMatching, TheNearerGrowsAndGapsClose) {
  const Image<float> image = step();
  const Image<float> edge = matched_in_windows(image, {.window_px = 4, .nearer_share = 0.2}, 20, 1);
  int grown = 0;
  for (int column = 20; column < 28; ++column)
    grown += edge(column, 15) > 0 && edge(column, 15) < 600 ? 1 : 0;
  EXPECT_GE(grown, 1);
  EXPECT_LE(grown, 4);
  Image<float> fingers = wall(500);
  for (int row = 0; row < 30; ++row) fingers(20, row) = 800;  // a gap of one pixel
  const Image<float> merged = matched_in_windows(fingers, {.window_px = 3}, 20, 1);
  for (int row = 0; row < 30; ++row) EXPECT_NEAR(merged(20, row), 500.0f, 1e-2f);
}

TEST(WindowMatching, EachFrameDrawsItsReach) {
  const WindowMatchingOptions options{.window_px = 2, .widest_window_px = 5, .window_share = 0.6};
  std::array<int, 7> counts{};
  for (std::uint64_t seed = 0; seed < 4000; ++seed) ++counts.at(drawn_window_px(options, seed));
  // 0.4 of 4,000 frames see no windows, 0.15 each reach; the deviation of a count is at most 31.
  EXPECT_NEAR(counts[0], 1600, 125);
  EXPECT_EQ(counts[1], 0);
  for (int reach = 2; reach <= 5; ++reach) EXPECT_NEAR(counts[reach], 600, 95) << reach;
  EXPECT_EQ(counts[6], 0);
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    EXPECT_EQ(drawn_window_px({.window_px = 3}, seed), 3);
    EXPECT_EQ(drawn_window_px({.window_px = 3, .widest_window_px = 1}, seed), 3);
    EXPECT_EQ(drawn_window_px({}, seed), 0);
  }
}

TEST(WindowMatching, EachFrameDrawsTheShareAtWhichTheNearerWins) {
  const WindowMatchingOptions options{.window_px = 3, .nearer_share = 0.3, .largest_nearer_share = 0.6};
  double sum = 0.0, least = 1.0, most = 0.0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const double share = drawn_nearer_share(options, seed);
    sum += share;
    least = std::min(least, share);
    most = std::max(most, share);
    EXPECT_EQ(drawn_nearer_share({.nearer_share = 0.5, .largest_nearer_share = 0.2}, seed), 0.5);
    EXPECT_EQ(drawn_nearer_share({.nearer_share = 0.5}, seed), 0.5);
  }
  EXPECT_NEAR(sum / 1000, 0.45, 0.012);  // four deviations
  EXPECT_GE(least, 0.3);
  EXPECT_LT(least, 0.31);
  EXPECT_LE(most, 0.6);
  EXPECT_GT(most, 0.59);
  const Image<float> image = step();
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const double share = drawn_nearer_share(options, seed);
    EXPECT_EQ(matched_in_windows(image, options, 20, seed),
              matched_in_windows(image, {.window_px = 3, .nearer_share = share}, 20, seed));
  }
}

TEST(WindowMatching, TheDrawnReachIsTheOneThatMatches) {
  const Image<float> image = step();
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const WindowMatchingOptions drawn{.window_px = 1, .widest_window_px = 4};
    const int reach = drawn_window_px(drawn, seed);
    EXPECT_EQ(matched_in_windows(image, drawn, 20, seed),
              matched_in_windows(image, {.window_px = reach}, 20, seed));
  }
}

TEST(WindowMatching, ThinThingsVanish) {
  Image<float> image = wall(800);
  for (int row = 0; row < 30; ++row) image(20, row) = 500;
  const Image<float> seen = matched_in_windows(image, {.window_px = 3}, 20, 1);
  for (int row = 5; row < 25; ++row) EXPECT_NEAR(seen(20, row), 800.0f, 1e-2f);
}

TEST(WindowMatching, AllPixelsAreDepthsOfTheirSurfacesOrNothing) {
  Image<float> image = wall(700);
  for (int row = 8; row < 22; ++row) {
    for (int column = 10; column < 25; ++column) image(column, row) = 400;
  }
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 40; ++column) image(column, row) = 0;
  }
  int lost = 0;
  const Image<float> seen = matched_in_windows(image, {.window_px = 3}, 20, 1);
  for (const float depth : seen.pixels()) {
    lost += depth == 0.0f ? 1 : 0;
    EXPECT_TRUE(depth == 0.0f || std::abs(depth - 400) < 0.1 || std::abs(depth - 700) < 0.1) << depth;
  }
  EXPECT_GT(lost, 3 * 40);
}

}  // namespace
}  // namespace knuckle
