// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace knuckle {

/// The bytes as a zlib stream (RFC 1950 and 1951), which is what HDF5's filter `deflate` stores.
std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> bytes);

/// The low bytes of all values and after them the high bytes: HDF5's filter `shuffle`. Noise and what lies
/// beneath it separate.
std::vector<std::uint8_t> shuffled(std::span<const std::uint16_t> values);

/// The bytes as deflate alone (RFC 1951), which is what a zip stores.
std::vector<std::uint8_t> deflated_raw(std::span<const std::uint8_t> bytes);

/// Inflates what `deflated_raw`, or another, made; false where that is not exactly as long as `to`, or
/// damaged.
bool inflate_raw(std::span<const std::uint8_t> stored, std::span<std::uint8_t> to);
/// The same of a zlib stream, whose sum is checked.
bool inflate(std::span<const std::uint8_t> stream, std::span<std::uint8_t> to);

/// Whether a sum is the expected one. Always, where the compiler builds for fuzzing: what lies after a sum
/// could not be reached by changing bytes at random.
inline bool is_sum([[maybe_unused]] std::uint64_t found, [[maybe_unused]] std::uint64_t expected) {
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
  return true;
#else
  return found == expected;
#endif
}

/// The sum of zips (CRC-32, RFC 1952); of bytes that follow others whose sum is `before`.
std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

/// The checksum of RFC 1950 (Adler-32).
std::uint32_t adler32(std::span<const std::uint8_t> bytes);

}  // namespace knuckle
