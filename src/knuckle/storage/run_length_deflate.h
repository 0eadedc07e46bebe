// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace knuckle {

/// The share of bytes, in [0, 1], that are the same as the one before them; 0 of no bytes.
double share_of_repeats(std::span<const std::uint8_t> bytes);

/// The bytes as a stream of RFC 1951 (deflate) that repeats runs of one byte and nothing else, with Huffman
/// codes of its own for every 64 KiB. Images that are empty but for a hand become as small as with a search
/// for any repetition, within 10 %, in a seventh of the instructions (docs/performance.md). The stream
/// depends on the bytes alone, not on processor or library. Safe to call from many threads.
std::vector<std::uint8_t> run_length_deflated(std::span<const std::uint8_t> bytes);

/// Lengths of Huffman codes [bits], at most `longest`, in the order of `counts`: 0 where a count is 0. A
/// single symbol gets a code of one bit. 2^longest must be at least the number of counts. Where the best code
/// is longer than `longest`, counts are halved until it is not.
std::vector<std::uint8_t> huffman_lengths(std::span<const std::uint32_t> counts, int longest);

}  // namespace knuckle
