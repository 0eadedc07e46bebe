// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/empty_blocks.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace knuckle {
namespace {

TEST(EmptyBlocks, AllZeroKnowsBothZerosAndTheSmallestNumber) {
  const std::vector<float> zeros{0.0f, -0.0f, 0.0f};
  EXPECT_TRUE(all_zero(zeros.data(), zeros.size()));
  EXPECT_TRUE(all_zero(nullptr, 0));
  for (const float value : {std::numeric_limits<float>::denorm_min(), -1.0f, std::nanf("")}) {
    const std::vector<float> values{0.0f, 0.0f, value};
    EXPECT_FALSE(all_zero(values.data(), 3)) << value;
    EXPECT_TRUE(all_zero(values.data(), 2)) << value;
  }
}

TEST(EmptyBlocks, EveryPixelThatIsNotZeroIsVisitedOnce) {
  for (const std::size_t size : {1u, 63u, 64u, 65u, 300u}) {
    for (const std::size_t seen : {std::size_t{0}, size / 2, size - 1}) {
      std::vector<float> depths(size, 0.0f);
      depths[seen] = 500.0f;
      std::vector<int> visits(size, 0);
      for_each_seen_block(depths.data(), size, [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) ++visits[i];
      });
      EXPECT_EQ(visits[seen], 1);
      for (std::size_t i = 0; i < size; ++i) EXPECT_EQ(visits[i], i / 64 == seen / 64 ? 1 : 0) << i;
    }
  }
}

}  // namespace
}  // namespace knuckle
