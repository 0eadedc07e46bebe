// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/depth_edges.h"

#include <cmath>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

bool is_edge(const Image<float>& image, int column, int row, float jump_mm) {
  const std::pair<int, int> neighbours[] = {
      {column - 1, row}, {column + 1, row}, {column, row - 1}, {column, row + 1}};
  for (const auto& [x, y] : neighbours) {
    if (image.contains(x, y) && std::abs(image(x, y) - image(column, row)) > jump_mm) return true;
  }
  return false;
}

TEST(DepthEdges, AreThePixelsWithAFarNeighbour) {
  for (const auto& [width, height] : {std::pair{37, 19}, {8, 8}, {1, 5}, {5, 1}, {16, 3}}) {
    Random random(width);
    Image<float> image(width, height);
    for (float& depth : image.pixels()) {
      depth = random.uniform() < 0.3 ? 0.0f : static_cast<float>(random.uniform(500, 540));
    }
    std::vector<std::int32_t> expected;
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < width; ++column) {
        if (is_edge(image, column, row, 20.0f)) expected.push_back(row * width + column);
      }
    }
    EXPECT_EQ(edge_pixels(image, 20.0), expected);
  }
}

TEST(DepthEdges, APlaneHasNone) {
  EXPECT_TRUE(edge_pixels(Image<float>(30, 20, 500.0f), 20.0).empty());
  EXPECT_TRUE(edge_pixels(Image<float>(), 20.0).empty());
}

}  // namespace
}  // namespace knuckle
