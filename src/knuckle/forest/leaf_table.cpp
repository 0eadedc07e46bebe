// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/leaf_table.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "knuckle/core/error.h"

namespace knuckle {

namespace {

template <class Code>
std::vector<Code> encoded(std::span<const float> values, const std::vector<float>& offset,
                          const std::vector<float>& step) {
  const std::size_t dimensions = offset.size();
  std::vector<Code> codes(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t d = i % dimensions;
    const double steps = std::round((double{values[i]} - double{offset[d]}) / double{step[d]});
    codes[i] =
        static_cast<Code>(std::clamp(steps, 0.0, static_cast<double>(std::numeric_limits<Code>::max())));
  }
  return codes;
}

}  // namespace

LeafTable::LeafTable(int dimensions, std::span<const float> values, int bits) {
  const auto columns = static_cast<std::size_t>(dimensions);
  offset_.assign(columns, 0.0F);
  step_.assign(columns, 1.0F);
  if (bits == 32) {
    codes_ = std::vector<float>(values.begin(), values.end());
    return;
  }
  if (bits != 8 && bits != 16) fail("forest leaves: {} bits per value, expected 8, 16 or 32", bits);
  for (std::size_t d = 0; d < columns && !values.empty(); ++d) {
    float lowest = values[d];
    float highest = values[d];
    for (std::size_t i = d; i < values.size(); i += columns) {
      lowest = std::min(lowest, values[i]);
      highest = std::max(highest, values[i]);
    }
    offset_[d] = lowest;
    if (highest > lowest) {
      step_[d] = static_cast<float>((double{highest} - double{lowest}) / ((1 << bits) - 1));
    }
  }
  if (bits == 8) {
    codes_ = encoded<std::uint8_t>(values, offset_, step_);
  } else {
    codes_ = encoded<std::uint16_t>(values, offset_, step_);
  }
}

LeafTable::LeafTable(std::vector<float> offset, std::vector<float> step, Codes codes,
                     const std::string& origin)
    : offset_(std::move(offset)), step_(std::move(step)), codes_(std::move(codes)) {
  const auto is_bad = [](float value) { return !std::isfinite(value); };
  if (offset_.empty() || offset_.size() != step_.size()) {
    fail("{}: {} leaf offsets and {} leaf steps, expected one of each a target", origin, offset_.size(),
         step_.size());
  }
  if (std::ranges::any_of(offset_, is_bad) || std::ranges::any_of(step_, is_bad)) {
    fail("{}: a leaf offset or step is not finite", origin);
  }
  std::visit(
      [&](const auto& values) {
        if (values.size() % offset_.size() != 0) {
          fail("{}: {} leaf values are no whole rows of {}", origin, values.size(), offset_.size());
        }
        using Code = typename std::decay_t<decltype(values)>::value_type;
        if constexpr (std::is_same_v<Code, float>) {
          if (std::ranges::any_of(values, is_bad)) fail("{}: a leaf value is not finite", origin);
        }
        float largest = static_cast<float>(std::numeric_limits<Code>::max());
        if constexpr (std::is_same_v<Code, float>) {
          largest = 0.0F;
          for (const float value : values) largest = std::max(largest, std::abs(value));
        }
        for (std::size_t d = 0; d < offset_.size(); ++d) {
          if (is_bad(offset_[d] + step_[d] * largest) || is_bad(offset_[d] - step_[d] * largest)) {
            fail("{}: a leaf value is not finite", origin);
          }
        }
      },
      codes_);
}

std::size_t LeafTable::leaf_count() const {
  if (offset_.empty()) return 0;
  return std::visit([&](const auto& values) { return values.size() / offset_.size(); }, codes_);
}

int LeafTable::bits() const {
  return std::visit(
      [](const auto& values) {
        return static_cast<int>(8 * sizeof(typename std::decay_t<decltype(values)>::value_type));
      },
      codes_);
}

void LeafTable::decode(std::size_t leaf, std::span<float> row) const {
  std::visit(
      [&](const auto& values) {
        const auto* const code = values.data() + leaf * offset_.size();
        for (std::size_t d = 0; d < offset_.size(); ++d)
          row[d] = offset_[d] + step_[d] * static_cast<float>(code[d]);
      },
      codes_);
}

std::vector<float> LeafTable::decoded() const {
  std::vector<float> values(leaf_count() * offset_.size());
  for (std::size_t leaf = 0; leaf < leaf_count(); ++leaf) {
    decode(leaf, std::span(values).subspan(leaf * offset_.size(), offset_.size()));
  }
  return values;
}

}  // namespace knuckle
