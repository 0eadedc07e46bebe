// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detection.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

DetectorMaps random_maps(std::uint64_t seed) {
  const DetectorOptions options;
  Random random(seed);
  DetectorMaps maps{options.map_width(), options.map_height(), {}};
  for (int i = 0; i < maps.width * maps.height; ++i) {
    maps.values.push_back(static_cast<float>(2.0 * random.normal() - 1.0));
    maps.values.push_back(static_cast<float>(random.uniform(-0.5, 0.5)));
    maps.values.push_back(static_cast<float>(random.uniform(-0.5, 0.5)));
    maps.values.push_back(static_cast<float>(random.uniform(-0.5, 1.2)));
    maps.values.push_back(static_cast<float>(random.uniform(-0.5, 0.3)));
    maps.values.push_back(static_cast<float>(random.normal()));
  }
  return maps;
}

/// Straight from the definition: every cell against every other.
std::vector<DetectedHand> hands_by_definition(const DetectorMaps& maps, const DetectorView& view,
                                              const DetectionOptions& options) {
  struct Cell {
    int column, row;
    double score;
  };
  std::vector<Cell> cells;
  for (int i = 0; i < maps.width * maps.height; ++i) {
    const int column = i % maps.width;
    const int row = i / maps.width;
    const double score = 1.0 / (1.0 + std::exp(-double(maps.cell(column, row)[kHeatMap])));
    bool is_largest = score >= options.min_score;
    for (int j = 0; j < maps.width * maps.height; ++j) {
      const bool touches = std::abs(j % maps.width - column) <= 1 && std::abs(j / maps.width - row) <= 1;
      if (j == i || !touches) continue;
      is_largest &= maps.cell(j % maps.width, j / maps.width)[kHeatMap] < maps.cell(column, row)[kHeatMap];
    }
    if (is_largest) cells.push_back({column, row, score});
  }
  std::ranges::sort(cells, std::greater{}, &Cell::score);
  std::vector<DetectedHand> hands;
  for (const Cell& cell : cells) {
    const float* const said = maps.cell(cell.column, cell.row);
    DetectedHand hand;
    hand.centre = view.to_camera({4.0 * (cell.column + said[kOffsetUMap]) + 1.5,
                                  4.0 * (cell.row + said[kOffsetVMap]) + 1.5, std::exp(double(said[3]))});
    hand.extent_mm = 100.0 * std::exp(double(said[kExtentMap]));
    hand.score = cell.score;
    hand.side = said[kSideMap] >= 0.0f ? HandSide::right : HandSide::left;
    bool is_free = true;
    for (const DetectedHand& other : hands) {
      is_free &= (other.centre - hand.centre).norm() >= options.separation_mm;
    }
    if (is_free) hands.push_back(hand);
  }
  return hands;
}

TEST(HandsIn, AreThoseOfTheDefinition) {
  const DetectorView view({}, testing::quarter_vga_camera());
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const DetectorMaps maps = random_maps(seed);
    for (const DetectionOptions& options :
         {DetectionOptions{}, DetectionOptions{0.9, 0.0}, DetectionOptions{0.5, 400.0}}) {
      const std::vector<DetectedHand> found = hands_in(maps, view, options);
      const std::vector<DetectedHand> expected = hands_by_definition(maps, view, options);
      ASSERT_GT(expected.size(), 1u);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_LT((found[i].centre - expected[i].centre).norm(), 1e-6);
        EXPECT_NEAR(found[i].extent_mm, expected[i].extent_mm, 1e-6);
        EXPECT_NEAR(found[i].score, expected[i].score, 1e-12);
        EXPECT_EQ(found[i].side, expected[i].side);
        EXPECT_GE(found[i].side_confidence, 0.5);
      }
    }
  }
}

TEST(HandsIn, MirroredMapsAreMirroredHandsOfTheOtherSide) {
  Camera camera = testing::quarter_vga_camera();
  camera.cx = 140.0;
  const DetectorView view({}, camera);
  const DetectorView mirror({}, mirrored(camera));
  const DetectorMaps maps = random_maps(3);
  DetectorMaps turned = maps;
  for (int row = 0; row < maps.height; ++row) {
    for (int column = 0; column < maps.width; ++column) {
      const std::size_t to = (static_cast<std::size_t>(row) * maps.width + column) * kDetectorMaps;
      std::copy_n(maps.cell(maps.width - 1 - column, row), kDetectorMaps, turned.values.begin() + to);
      turned.values[to + kOffsetUMap] *= -1.0f;
      turned.values[to + kSideMap] *= -1.0f;
    }
  }
  const std::vector<DetectedHand> hands = hands_in(maps, view, {});
  const std::vector<DetectedHand> others = hands_in(turned, mirror, {});
  ASSERT_EQ(hands.size(), others.size());
  for (std::size_t i = 0; i < hands.size(); ++i) {
    EXPECT_NEAR(others[i].centre.x(), -hands[i].centre.x(), 1e-3);
    EXPECT_NEAR(others[i].centre.y(), hands[i].centre.y(), 1e-3);
    EXPECT_NE(others[i].side, hands[i].side);
  }
}

TEST(HandsIn, EqualCellsAreOneHand) {
  const DetectorView view({}, testing::quarter_vga_camera());
  DetectorMaps maps = random_maps(1);
  for (std::size_t i = 0; i < maps.values.size(); i += kDetectorMaps) maps.values[i] = 2.0f;
  EXPECT_EQ(hands_in(maps, view, {}).size(), 1u);
}

TEST(HandsIn, StaysFiniteWhateverTheNumbers) {
  const DetectorView view({}, testing::quarter_vga_camera());
  for (const float number : {-1e30f, -1e4f, 1e4f, 1e30f}) {
    DetectorMaps maps = random_maps(1);
    for (std::size_t i = 0; i < maps.values.size(); ++i) {
      if (i % kDetectorMaps >= kInverseDepthMap) maps.values[i] = number;
    }
    for (const DetectedHand& hand : hands_in(maps, view, {})) {
      EXPECT_TRUE(hand.centre.allFinite());
      EXPECT_TRUE(std::isfinite(hand.extent_mm + hand.score + hand.side_confidence));
    }
  }
}

}  // namespace
}  // namespace knuckle
