// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/mask_filters.h"

#include <algorithm>
#include <span>
#include <vector>

namespace knuckle {
namespace {

/// Each sum is that of `side` values from its own place on. Adding shifted rows is vector code, a running sum
/// is not: for the few pixels of a filter it is faster.
void add_along_row(std::span<const std::uint16_t> values, int side, std::span<std::uint16_t> sums) {
  std::ranges::fill(sums, std::uint16_t{0});
  for (int shift = 0; shift < side; ++shift) {
    for (std::size_t i = 0; i < sums.size(); ++i)
      sums[i] = static_cast<std::uint16_t>(sums[i] + values[i + static_cast<std::size_t>(shift)]);
  }
}

template <class Condition>
Image<std::uint8_t> where(const Image<std::uint16_t>& sums, Condition holds) {
  Image<std::uint8_t> result(sums.width(), sums.height());
  std::ranges::transform(sums.pixels(), result.data(),
                         [&](std::uint16_t sum) { return static_cast<std::uint8_t>(holds(sum)); });
  return result;
}

}  // namespace

Image<std::uint16_t> set_in_square(const Image<std::uint8_t>& mask, int side) {
  const int half = side / 2;
  const int height = mask.height();
  Image<std::uint16_t> result(mask.width(), height);
  // The sums of each column over the rows that the square covers, with columns of 0 on both sides.
  std::vector<std::uint16_t> padded(static_cast<std::size_t>(mask.width() + 2 * half), 0);
  const std::span<std::uint16_t> columns = std::span(padded).subspan(half, mask.width());
  const auto add = [&](int row) {
    const std::span<const std::uint8_t> pixels = mask.row(row);
    for (std::size_t i = 0; i < columns.size(); ++i)
      columns[i] = static_cast<std::uint16_t>(columns[i] + pixels[i]);
  };
  const auto subtract = [&](int row) {
    const std::span<const std::uint8_t> pixels = mask.row(row);
    for (std::size_t i = 0; i < columns.size(); ++i)
      columns[i] = static_cast<std::uint16_t>(columns[i] - pixels[i]);
  };
  for (int row = 0; row < std::min(half, height); ++row) add(row);
  for (int row = 0; row < height; ++row) {
    if (row + half < height) add(row + half);
    add_along_row(padded, side, result.row(row));
    if (row - half >= 0) subtract(row - half);
  }
  return result;
}

Image<std::uint8_t> majority(const Image<std::uint8_t>& mask, int side) {
  return where(set_in_square(mask, side), [half = side * side / 2](std::uint16_t sum) { return sum > half; });
}

Image<std::uint8_t> dilated(const Image<std::uint8_t>& mask, int side) {
  return where(set_in_square(mask, side), [](std::uint16_t sum) { return sum > 0; });
}

Image<std::uint8_t> eroded(const Image<std::uint8_t>& mask, int side) {
  const auto inverted = [](const Image<std::uint8_t>& image) {
    Image<std::uint8_t> result = image;
    for (std::uint8_t& pixel : result.pixels()) pixel = pixel == 0;
    return result;
  };
  return where(set_in_square(inverted(mask), side), [](std::uint16_t sum) { return sum == 0; });
}

}  // namespace knuckle
