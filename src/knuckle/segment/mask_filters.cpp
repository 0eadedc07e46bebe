// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/mask_filters.h"

#include <algorithm>
#include <span>
#include <vector>

namespace knuckle {
namespace {

/// The sums of `half` pixels to both sides of each, and itself.
void add_along_row(std::span<const std::uint16_t> values, int half, std::span<std::uint16_t> sums) {
  const int size = static_cast<int>(values.size());
  std::uint16_t sum = 0;
  for (int i = 0; i < std::min(half, size); ++i) sum += values[i];
  for (int i = 0; i < size; ++i) {
    if (i + half < size) sum += values[i + half];
    sums[i] = sum;
    if (i - half >= 0) sum -= values[i - half];
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
  std::vector<std::uint16_t> columns(mask.width(), 0);  // of the rows that the square covers
  const auto add = [&](int row) {
    std::ranges::transform(
        columns, mask.row(row), columns.begin(),
        [](std::uint16_t sum, std::uint8_t pixel) { return static_cast<std::uint16_t>(sum + pixel); });
  };
  const auto subtract = [&](int row) {
    std::ranges::transform(
        columns, mask.row(row), columns.begin(),
        [](std::uint16_t sum, std::uint8_t pixel) { return static_cast<std::uint16_t>(sum - pixel); });
  };
  for (int row = 0; row < std::min(half, height); ++row) add(row);
  for (int row = 0; row < height; ++row) {
    if (row + half < height) add(row + half);
    add_along_row(columns, half, result.row(row));
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
