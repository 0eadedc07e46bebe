// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/huffman_code.h"

#include <cmath>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;

double kraft_sum(const std::vector<int>& lengths) {
  double sum = 0.0;
  for (const int length : lengths) sum += length > 0 ? std::ldexp(1.0, -length) : 0.0;
  return sum;
}

TEST(HuffmanCode, LengthsOfAKnownExample) {
  // The weights 1, 1, 2, 4 make a chain.
  EXPECT_THAT(huffman_lengths(std::vector<std::uint32_t>{4, 1, 0, 1, 2}, 15), ElementsAre(1, 3, 0, 3, 2));
}

TEST(HuffmanCode, ALoneSymbolTakesOneBit) {
  EXPECT_THAT(huffman_lengths(std::vector<std::uint32_t>{0, 9, 0}, 15), ElementsAre(0, 1, 0));
  EXPECT_THAT(huffman_lengths(std::vector<std::uint32_t>{0, 0}, 15), ElementsAre(0, 0));
}

TEST(HuffmanCode, IsCompleteAndWithinABitOfTheEntropy) {
  Random random(3);
  for (int round = 0; round < 50; ++round) {
    std::vector<std::uint32_t> counts(200);
    double total = 0.0;
    for (auto& count : counts) total += count = 1 + random.below(1000);
    const std::vector<int> lengths = huffman_lengths(counts, 15);
    EXPECT_DOUBLE_EQ(kraft_sum(lengths), 1.0);
    double entropy = 0.0;
    double mean_length = 0.0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const double share = counts[i] / total;
      entropy -= share * std::log2(share);
      mean_length += share * lengths[i];
    }
    EXPECT_GE(mean_length, entropy);
    EXPECT_LT(mean_length, entropy + 1.0);
  }
}

TEST(HuffmanCode, StaysWithinTheLongestLength) {
  std::vector<std::uint32_t> fibonacci{1, 1};
  while (fibonacci.size() < 30) fibonacci.push_back(fibonacci.back() + fibonacci[fibonacci.size() - 2]);
  EXPECT_EQ(std::ranges::max(huffman_lengths(fibonacci, 40)), 29);
  const std::vector<int> limited = huffman_lengths(fibonacci, 15);
  EXPECT_LE(std::ranges::max(limited), 15);
  EXPECT_DOUBLE_EQ(kraft_sum(limited), 1.0);
}

TEST(HuffmanCode, CanonicalCodeOfTheStandardsExample) {
  // RFC 1951, 3.2.2: lengths (3, 3, 3, 3, 3, 2, 4, 4) give 010 011 100 101 110 00 1110 1111, first bit first.
  const std::vector<BitCode> code = canonical_code(std::vector<int>{3, 3, 3, 3, 3, 2, 4, 4});
  const std::vector<std::uint32_t> reversed{0b010, 0b110, 0b001, 0b101, 0b011, 0b00, 0b0111, 0b1111};
  for (std::size_t i = 0; i < code.size(); ++i) EXPECT_EQ(code[i].bits, reversed[i]) << i;
}

}  // namespace
}  // namespace knuckle
