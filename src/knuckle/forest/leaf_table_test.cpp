// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/leaf_table.h"

#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

const std::vector<float> kValues{-1.0F, 5.0F, 0.3F, 5.0F, 0.9F, 5.0F};

TEST(LeafTable, LosesAtMostHalfAStep) {
  for (const int bits : {8, 16, 32}) {
    const LeafTable table(2, kValues, bits);
    EXPECT_EQ(table.bits(), bits);
    ASSERT_EQ(table.leaf_count(), 3U);
    const double step = bits == 32 ? 0.0 : 1.9 / (std::pow(2.0, bits) - 1.0);
    const std::vector<float> decoded = table.decoded();
    for (std::size_t i = 0; i < kValues.size(); ++i) {
      EXPECT_NEAR(decoded[i], kValues[i], i % 2 == 0 ? 0.5001 * step + (bits == 32 ? 0.0 : 1e-7) : 0.0)
          << bits;
    }
  }
}

TEST(LeafTable, EncodingAgainChangesNothing) {
  const LeafTable once(2, kValues, 8);
  const LeafTable twice(2, once.decoded(), 8);
  EXPECT_EQ(once.codes(), twice.codes());
  EXPECT_EQ(once.decoded(), twice.decoded());
}

TEST(LeafTable, RefusesPartsThatDoNotFit) {
  const std::vector<float> one{1.0F};
  EXPECT_THAT(error_of([] { LeafTable(2, kValues, 12); }), HasSubstr("12 bits"));
  EXPECT_THAT(error_of([&] {
                LeafTable({0.0F, 0.0F}, one, std::vector<float>{}, "a.model");
              }),
              HasSubstr("a.model"));
  EXPECT_THAT(error_of([&] {
                LeafTable({0.0F, 0.0F}, {1.0F, 1.0F}, one, "a.model");
              }),
              HasSubstr("no whole rows"));
  EXPECT_THAT(error_of([&] { LeafTable({0.0F}, one, std::vector<float>{NAN}, "a.model"); }),
              HasSubstr("not finite"));
  EXPECT_THAT(error_of([&] { LeafTable({INFINITY}, one, one, "a.model"); }),
              HasSubstr("offset or step is not finite"));
  // All parts are finite, what they make is not.
  EXPECT_THAT(error_of([&] { LeafTable({3e38F}, {3e36F}, std::vector<std::uint8_t>{1}, "a.model"); }),
              HasSubstr("a leaf value is not finite"));
  EXPECT_THAT(error_of([&] { LeafTable({3e38F}, one, std::vector<float>{-3e38F}, "a.model"); }),
              HasSubstr("a leaf value is not finite"));
}

}  // namespace
}  // namespace knuckle
