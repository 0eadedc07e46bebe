// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace knuckle {

/// Whether all values are 0, of either sign. There is no way out of its loop, so that many are looked at at
/// once.
inline bool all_zero(const float* values, std::size_t count) {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < count; ++i) bits |= std::bit_cast<std::uint32_t>(values[i]);
  return bits << 1 == 0;
}

/// Calls `work(first, end)` for blocks of 64 pixels of a depth image [mm] in which anything was measured.
/// Most of an image of a hand before nothing is left out.
template <typename Work>
void for_each_seen_block(const float* depth_mm, std::size_t count, const Work& work) {
  constexpr std::size_t kBlock = 64;
  for (std::size_t first = 0; first < count; first += kBlock) {
    const std::size_t end = std::min(first + kBlock, count);
    if (!all_zero(depth_mm + first, end - first)) work(first, end);
  }
}

}  // namespace knuckle
