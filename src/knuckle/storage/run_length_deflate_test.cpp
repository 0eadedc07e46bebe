// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/run_length_deflate.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

/// Whether a code of such lengths leaves nothing over (Kraft's equation).
bool is_complete(const std::vector<std::uint8_t>& lengths) {
  double sum = 0.0;
  for (const std::uint8_t length : lengths) sum += length > 0 ? std::ldexp(1.0, -length) : 0.0;
  return sum == 1.0;
}

std::uint64_t bits_of(const std::vector<std::uint32_t>& counts, const std::vector<std::uint8_t>& lengths) {
  return std::transform_reduce(counts.begin(), counts.end(), lengths.begin(), std::uint64_t{0}, std::plus<>(),
                               [](std::uint64_t count, std::uint8_t length) { return count * length; });
}

TEST(HuffmanLengths, OfATextbooksExample) {
  // Cormen, Leiserson, Rivest and Stein: a to f occur 45, 13, 12, 16, 9, 5 times, and take 224 bits.
  const std::vector<std::uint32_t> counts{45, 13, 12, 16, 9, 5};
  const std::vector<std::uint8_t> lengths = huffman_lengths(counts, 15);
  EXPECT_EQ(lengths, (std::vector<std::uint8_t>{1, 3, 3, 3, 4, 4}));
  EXPECT_EQ(bits_of(counts, lengths), 224u);
}

TEST(HuffmanLengths, LieWithinABitOfTheEntropy) {
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<std::uint32_t> counts(2 + random.below(284));
    for (auto& count : counts) count = random.below(1 + random.below(1000));
    counts.front() = counts.back() = 1;
    const double total = std::accumulate(counts.begin(), counts.end(), 0.0);
    double entropy = 0.0;
    for (const std::uint32_t count : counts) entropy -= count > 0 ? count * std::log2(count / total) : 0.0;
    const std::vector<std::uint8_t> lengths = huffman_lengths(counts, 15);
    EXPECT_TRUE(is_complete(lengths));
    const auto bits = static_cast<double>(bits_of(counts, lengths));
    EXPECT_GE(bits, entropy - 1e-6);
    EXPECT_LT(bits, entropy + total);
    for (std::size_t i = 0; i < counts.size(); ++i) EXPECT_EQ(lengths[i] > 0, counts[i] > 0) << i;
  }
}

TEST(HuffmanLengths, StayWithinTheLimit) {
  std::vector<std::uint32_t> fibonacci{1, 1};  // the counts whose best code is the longest: 29 bits
  while (fibonacci.size() < 30) fibonacci.push_back(fibonacci.rbegin()[0] + fibonacci.rbegin()[1]);
  for (const int longest : {7, 15}) {
    const std::vector<std::uint8_t> lengths = huffman_lengths(fibonacci, longest);
    EXPECT_LE(*std::max_element(lengths.begin(), lengths.end()), longest);
    EXPECT_TRUE(is_complete(lengths));
  }
}

TEST(HuffmanLengths, OfOneSymbolIsOneBitAndOfNoneNothing) {
  EXPECT_EQ(huffman_lengths(std::vector<std::uint32_t>{0, 9, 0}, 7), (std::vector<std::uint8_t>{0, 1, 0}));
  EXPECT_EQ(huffman_lengths(std::vector<std::uint32_t>{0, 0}, 7), (std::vector<std::uint8_t>{0, 0}));
}

TEST(ShareOfRepeats, CountsBytesThatAreLikeTheOneBefore) {
  EXPECT_EQ(share_of_repeats({}), 0.0);
  EXPECT_EQ(share_of_repeats(std::vector<std::uint8_t>{5}), 0.0);
  EXPECT_EQ(share_of_repeats(std::vector<std::uint8_t>{5, 5, 5, 6, 5, 5, 7, 7}), 0.5);
}

TEST(RunLengthDeflate, WritesTheBitsOfTheStandard) {
  // One block with codes of its own (bits 1, then 2), 286 and 1 codes, 19 lengths of code lengths:
  // 1 | 01 (lowest bit first: 10) | 29 | 0 | 15.
  const std::vector<std::uint8_t> stream = run_length_deflated(std::vector<std::uint8_t>(1000, 0));
  const unsigned head =
      stream[0] | static_cast<unsigned>(stream[1]) << 8 | static_cast<unsigned>(stream[2]) << 16;
  EXPECT_EQ(head & 1u, 1u);
  EXPECT_EQ(head >> 1 & 3u, 2u);
  EXPECT_EQ(head >> 3 & 31u, 29u);
  EXPECT_EQ(head >> 8 & 31u, 0u);
  EXPECT_EQ(head >> 13 & 15u, 15u);
  EXPECT_LT(stream.size(), 40u);
}

}  // namespace
}  // namespace knuckle
