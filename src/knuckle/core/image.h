// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace knuckle {

/// A single-channel image that owns its pixels: row-major, contiguous, no padding.
/// The centre of pixel (column i, row j) lies at (u, v) = (i, j).
template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T value = T{})
      : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * height, value) {}

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t size() const { return pixels_.size(); }
  bool empty() const { return pixels_.empty(); }
  bool contains(int column, int row) const {
    return column >= 0 && column < width_ && row >= 0 && row < height_;
  }

  T& operator()(int column, int row) { return pixels_[index(column, row)]; }
  const T& operator()(int column, int row) const { return pixels_[index(column, row)]; }

  std::span<T> pixels() { return pixels_; }
  std::span<const T> pixels() const { return pixels_; }
  std::span<T> row(int row) { return std::span<T>(pixels_).subspan(index(0, row), width_); }
  std::span<const T> row(int row) const { return std::span<const T>(pixels_).subspan(index(0, row), width_); }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }

  bool operator==(const Image&) const = default;

 private:
  std::size_t index(int column, int row) const {
    assert(column >= 0 && column <= width_ && row >= 0 && row < height_);
    return static_cast<std::size_t>(row) * width_ + column;
  }

  int width_ = 0;
  int height_ = 0;
  std::vector<T> pixels_;
};

/// The image seen in a mirror: column i moves to column width - 1 - i.
template <class T>
Image<T> mirrored(const Image<T>& image) {
  Image<T> result = image;
  for (int row = 0; row < image.height(); ++row) std::ranges::reverse(result.row(row));
  return result;
}

}  // namespace knuckle
