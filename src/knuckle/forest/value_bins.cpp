// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/value_bins.h"

#include <algorithm>
#include <cstddef>

namespace knuckle {

ValueBins::ValueBins(std::span<const std::int16_t> values, int count) {
  std::int16_t lowest = values[0];
  std::int16_t highest = values[0];
  for (const std::int16_t value : values) {  // vectorises; std::minmax_element does not
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  lowest_ = lowest;
  const int distinct = highest - lowest + 1;
  count_ = std::min(count, distinct);
  if (distinct > count)
    factor_ = (static_cast<std::uint32_t>(count) << 16U) / static_cast<std::uint32_t>(distinct);
}

void ValueBins::assign(std::span<const std::int16_t> values, std::uint8_t* bins) const {
  const auto lowest = static_cast<std::uint16_t>(lowest_);
  const std::size_t count = values.size();
  const std::int16_t* value = values.data();
  if (factor_ == 0) {
    for (std::size_t i = 0; i < count; ++i) {
      bins[i] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(value[i]) - lowest);
    }
    return;
  }
  const std::uint32_t factor = factor_;
  for (std::size_t i = 0; i < count; ++i) {
    const auto above = static_cast<std::uint16_t>(static_cast<std::uint16_t>(value[i]) - lowest);
    bins[i] = static_cast<std::uint8_t>((above * factor) >> 16U);
  }
}

int ValueBins::first_value(int bin) const {
  if (factor_ == 0) return lowest_ + bin;
  const std::uint32_t above = ((static_cast<std::uint32_t>(bin) << 16U) + factor_ - 1) / factor_;
  return lowest_ + static_cast<int>(above);
}

}  // namespace knuckle
