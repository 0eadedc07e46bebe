// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/random.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace knuckle {
namespace {

// Known answers of philox4x32-10 that its authors publish with Random123.
TEST(RandomTest, PhiloxGivesThePublishedAnswers) {
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}),
            (std::array<std::uint32_t, 4>{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (std::array<std::uint32_t, 4>{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (std::array<std::uint32_t, 4>{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomTest, StreamsRepeatAndDiffer) {
  Random a(7, 1);
  Random same(7, 1);
  Random other_stream(7, 2);
  Random other_seed(8, 1);
  const auto word = a();
  EXPECT_EQ(word, same());
  EXPECT_NE(word, other_stream());
  EXPECT_NE(word, other_seed());
}

// The same published answers: a stream is the cipher of a counter whose words are block and stream.
TEST(RandomTest, AStreamIsTheCipherOfItsBlocks) {
  Random zero(0, 0);
  for (const std::uint32_t word : {0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u})
    EXPECT_EQ(zero(), word);
  EXPECT_EQ(zero(), philox({1, 0, 0, 0}, {0, 0})[0]);
  Random random(0x299f31d0a4093822, 0x0370734413198a2e);
  const auto expected = philox({0, 0, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0});
  for (const std::uint32_t word : expected) EXPECT_EQ(random(), word);
}

TEST(RandomTest, EveryBitOfSeedStreamAndNumberCounts) {
  std::set<std::uint32_t> words{Random(0, 0)()};
  std::set<std::uint64_t> seeds{derived_seed(0, 0)};
  for (int bit = 0; bit < 64; ++bit) {
    const std::uint64_t one = std::uint64_t{1} << bit;
    words.insert({Random(one, 0)(), Random(0, one)()});
    seeds.insert({derived_seed(one, 0), derived_seed(0, one)});
  }
  EXPECT_EQ(words.size(), 129u);
  EXPECT_EQ(seeds.size(), 129u);
  std::uint64_t set_bits = 0;
  for (const std::uint64_t seed : seeds) set_bits |= seed;
  EXPECT_EQ(set_bits, ~std::uint64_t{0});
}

TEST(RandomTest, UniformHasTheMomentsOfTheUnitInterval) {
  Random random(1);
  constexpr int kCount = 100000;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.uniform();
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / kCount, 0.5, 0.005);
  EXPECT_NEAR(squares / kCount, 1.0 / 3.0, 0.005);
}

TEST(RandomTest, NormalHasZeroMeanUnitDeviationAndNoSkew) {
  Random random(2);
  constexpr int kCount = 100000;
  double moments[4] = {};
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    for (int power = 0; power < 4; ++power) moments[power] += std::pow(x, power + 1) / kCount;
  }
  EXPECT_NEAR(moments[0], 0.0, 0.015);
  EXPECT_NEAR(moments[1], 1.0, 0.02);
  EXPECT_NEAR(moments[2], 0.0, 0.05);
  EXPECT_NEAR(moments[3], 3.0, 0.15);
}

TEST(RandomTest, UniformReachesFromEndToEnd) {
  Random random(5);
  constexpr int kCount = 100000;
  double sum = 0.0;
  double least = 10.0;
  double most = -10.0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.uniform(-3.0, 7.0);
    sum += x;
    least = std::min(least, x);
    most = std::max(most, x);
  }
  EXPECT_NEAR(sum / kCount, 2.0, 0.05);
  EXPECT_NEAR(least, -3.0, 0.01);
  EXPECT_GE(least, -3.0);
  EXPECT_NEAR(most, 7.0, 0.01);
  EXPECT_LT(most, 7.0);
}

TEST(RandomTest, NeighbouringNormalsHaveNothingToDoWithOneAnother) {
  Random random(6);
  constexpr int kCount = 100000;
  double products[2] = {};
  double fourth_moments[2] = {};
  double last = random.normal();
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    products[i % 2] += x * last / (kCount / 2);
    fourth_moments[i % 2] += x * x * last * last / (kCount / 2);
    last = x;
  }
  for (const double product : products) EXPECT_NEAR(product, 0.0, 0.02);
  for (const double moment : fourth_moments) EXPECT_NEAR(moment, 1.0, 0.05);
}

TEST(RandomTest, BelowReachesEveryNumberEquallyOften) {
  Random random(3);
  constexpr std::uint32_t kNumbers = 7;
  constexpr int kCount = 70000;
  std::vector<int> histogram(kNumbers);
  for (int i = 0; i < kCount; ++i) ++histogram.at(random.below(kNumbers));
  for (const int count : histogram) EXPECT_NEAR(count, kCount / kNumbers, 500);
  EXPECT_EQ(Random(4).below(1), 0u);
}

TEST(RandomTest, DerivedSeedsDiffer) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (std::uint64_t number = 0; number < 100; ++number) seeds.insert(derived_seed(seed, number));
  }
  EXPECT_EQ(seeds.size(), 1000u);
}

}  // namespace
}  // namespace knuckle
