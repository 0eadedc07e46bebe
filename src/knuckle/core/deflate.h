// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace knuckle {

/// The bytes as a zlib stream (RFC 1950 and 1951), for inflaters of all kinds. Runs of one value become
/// repeats of the byte before, all else Huffman-coded literals; each `block_size` bytes (at least 1) have a
/// code of their own. Made for depth images and masks, plain areas beside noise, in which a search for longer
/// repeats finds nothing but takes most of the time (docs/performance.md).
std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> bytes, std::size_t block_size);

/// The low bytes of all values and behind them the high bytes: HDF5's filter `shuffle`. Noise and what lies
/// beneath it separate.
std::vector<std::uint8_t> shuffled(std::span<const std::uint16_t> values);

/// The checksum of RFC 1950 (Adler-32).
std::uint32_t adler32(std::span<const std::uint8_t> bytes);

}  // namespace knuckle
