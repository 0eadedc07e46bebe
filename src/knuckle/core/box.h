// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace knuckle {

/// An axis-aligned rectangle of whole pixels: columns [x, x + width), rows [y, y + height).
struct Box {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;

  bool empty() const { return width <= 0 || height <= 0; }
  int right() const { return x + width; }    ///< first column after the box
  int bottom() const { return y + height; }  ///< first row after the box
  std::int64_t area() const { return empty() ? 0 : std::int64_t{width} * height; }
  bool contains(int column, int row) const {
    return column >= x && column < right() && row >= y && row < bottom();
  }
  bool operator==(const Box&) const = default;
};

/// The pixels that lie in both boxes; an empty box where none does.
inline Box intersection(const Box& a, const Box& b) {
  const int x = std::max(a.x, b.x);
  const int y = std::max(a.y, b.y);
  const Box common{x, y, std::min(a.right(), b.right()) - x, std::min(a.bottom(), b.bottom()) - y};
  return common.empty() ? Box{} : common;
}

}  // namespace knuckle
