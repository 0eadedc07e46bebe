// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/huffman_code.h"

#include <algorithm>
#include <numeric>

namespace knuckle {
namespace {

/// The symbols that occur, rare ones first.
std::vector<std::size_t> symbols_by_count(std::span<const std::uint32_t> counts) {
  std::vector<std::size_t> symbols;
  for (std::size_t symbol = 0; symbol < counts.size(); ++symbol)
    if (counts[symbol] > 0) symbols.push_back(symbol);
  std::ranges::stable_sort(symbols, {}, [&](std::size_t symbol) { return counts[symbol]; });
  return symbols;
}

/// Joins the two lightest nodes until one is left. Nodes are the leaves by rising weight and behind them the
/// inner ones, which come into being by rising weight too: the lightest is always at the head of either row.
std::vector<std::size_t> parents_of_tree(std::vector<std::uint64_t> weights) {
  const std::size_t leaves = weights.size();
  std::vector<std::size_t> parents(2 * leaves - 1);
  std::size_t leaf = 0;
  std::size_t inner = leaves;
  while (weights.size() < parents.size()) {
    const std::size_t joined = weights.size();
    weights.push_back(0);
    for (int child = 0; child < 2; ++child) {
      const bool is_leaf = leaf < leaves && (inner == joined || weights[leaf] <= weights[inner]);
      const std::size_t lightest = is_leaf ? leaf++ : inner++;
      weights[joined] += weights[lightest];
      parents[lightest] = joined;
    }
  }
  return parents;
}

std::vector<int> optimal_lengths(std::span<const std::uint32_t> counts) {
  std::vector<int> lengths(counts.size(), 0);
  const std::vector<std::size_t> symbols = symbols_by_count(counts);
  if (symbols.empty()) return lengths;
  std::vector<std::uint64_t> weights;
  for (const std::size_t symbol : symbols) weights.push_back(counts[symbol]);
  const std::vector<std::size_t> parents = parents_of_tree(std::move(weights));
  std::vector<int> depths(parents.size(), 0);
  for (std::size_t node = parents.size() - 1; node-- > 0;) depths[node] = depths[parents[node]] + 1;
  for (std::size_t i = 0; i < symbols.size(); ++i) lengths[symbols[i]] = std::max(1, depths[i]);
  return lengths;
}

std::uint32_t reversed(std::uint32_t code, int length) {
  std::uint32_t bits = 0;
  for (int i = 0; i < length; ++i) bits |= ((code >> i) & 1u) << (length - 1 - i);
  return bits;
}

}  // namespace

std::vector<int> huffman_lengths(std::span<const std::uint32_t> counts, int longest) {
  std::vector<std::uint32_t> evened(counts.begin(), counts.end());
  std::vector<int> lengths = optimal_lengths(evened);
  while (std::ranges::any_of(lengths, [&](int length) { return length > longest; })) {
    for (std::uint32_t& count : evened) count = (count + 1) / 2;  // one that occurs stays above 0
    lengths = optimal_lengths(evened);
  }
  return lengths;
}

std::vector<BitCode> canonical_code(std::span<const int> lengths) {
  const int longest = lengths.empty() ? 0 : std::ranges::max(lengths);
  std::vector<BitCode> code(lengths.size());
  std::uint32_t next = 0;
  for (int length = 1; length <= longest; ++length, next <<= 1) {
    for (std::size_t symbol = 0; symbol < lengths.size(); ++symbol)
      if (lengths[symbol] == length) code[symbol] = {reversed(next++, length), length};
  }
  return code;
}

}  // namespace knuckle
