// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace knuckle {

/// The bits that stand for one symbol in a bit stream, the first in the lowest place.
struct BitCode {
  std::uint32_t bits = 0;
  int length = 0;  ///< 0: the symbol does not occur
};

/// Lengths of a prefix code (Huffman 1952) for symbols that occur `counts` times: 0 for one that never does,
/// at most `longest` bits otherwise. Nearly optimal where that limit is met, optimal elsewhere.
std::vector<int> huffman_lengths(std::span<const std::uint32_t> counts, int longest);

/// The canonical code of these lengths (RFC 1951, section 3.2.2).
std::vector<BitCode> canonical_code(std::span<const int> lengths);

}  // namespace knuckle
