// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/components.h"

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "knuckle/core/random.h"

namespace knuckle::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Image<std::uint8_t> drawn(const std::vector<std::string>& rows) {
  Image<std::uint8_t> mask(static_cast<int>(rows.front().size()), static_cast<int>(rows.size()));
  for (int row = 0; row < mask.height(); ++row) {
    for (int column = 0; column < mask.width(); ++column)
      mask(column, row) = rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] == '#';
  }
  return mask;
}

/// By flooding from each pixel that no component has yet.
std::vector<std::vector<std::int32_t>> flooded(const Image<std::uint8_t>& mask) {
  std::vector<std::vector<std::int32_t>> components;
  Image<std::uint8_t> left = mask;
  for (int i = 0; i < static_cast<int>(mask.size()); ++i) {
    if (left.data()[i] == 0) continue;
    std::vector<std::int32_t> open{i};
    left.data()[i] = 0;
    components.emplace_back();
    while (!open.empty()) {
      const int pixel = open.back();
      open.pop_back();
      components.back().push_back(pixel);
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          const int column = pixel % mask.width() + x;
          const int row = pixel / mask.width() + y;
          if (!mask.contains(column, row) || left(column, row) == 0) continue;
          left(column, row) = 0;
          open.push_back(row * mask.width() + column);
        }
      }
    }
    std::ranges::sort(components.back());
  }
  return components;
}

TEST(ComponentsTest, CornersJoin) {
  EXPECT_THAT(components_of(drawn({"#..", ".#.", "..#"})), ElementsAre(ElementsAre(0, 4, 8)));
  EXPECT_THAT(components_of(drawn({"..#", ".#.", "#.."})), ElementsAre(ElementsAre(2, 4, 6)));
}

TEST(ComponentsTest, ArmsThatMeetBelowAreOne) {
  EXPECT_THAT(components_of(drawn({"#.#.#", "#.#.#", "#####"})).size(), 1);
  EXPECT_THAT(components_of(drawn({"#.#", "...", "#.#"})).size(), 4);
}

TEST(ComponentsTest, NothingSetIsNoComponent) {
  EXPECT_THAT(components_of({}), IsEmpty());
  EXPECT_THAT(components_of(Image<std::uint8_t>(5, 4)), IsEmpty());
}

TEST(ComponentsTest, AgreeWithFlooding) {
  for (int seed = 0; seed < 60; ++seed) {
    Random random(5, static_cast<std::uint64_t>(seed));
    Image<std::uint8_t> mask(1 + static_cast<int>(random.below(40)), 1 + static_cast<int>(random.below(40)));
    const double share = random.uniform(0.1, 0.9);
    for (std::uint8_t& pixel : mask.pixels()) pixel = random.uniform(0.0, 1.0) < share ? 255 : 0;
    EXPECT_EQ(components_of(mask), flooded(mask)) << mask.width() << " x " << mask.height();
  }
}

}  // namespace
}  // namespace knuckle::testing
