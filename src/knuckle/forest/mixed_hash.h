// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace knuckle {

/// One step of a multiplicative hash: the odd constant is 2^64 divided by the golden ratio (Knuth, vol. 3,
/// 6.4).
inline std::uint64_t mixed_hash(std::uint64_t hash, std::uint64_t word) {
  hash = (hash ^ word) * 0x9E3779B97F4A7C15ULL;
  return hash ^ (hash >> 32U);
}

}  // namespace knuckle
