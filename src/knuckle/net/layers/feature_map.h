// SPDX-License-Identifier: Apache-2.0
// Private to the modules of networks.
#pragma once

#include <cstddef>

#include "knuckle/net/layers/aligned_vector.h"
#include "knuckle/net/layers/float_lanes.h"

namespace knuckle {

/// What a layer of a network reads and writes: height x width pixels, each with all its channels side by
/// side, and a border of zeros around them, so that a padded convolution needs no exceptions at the rim.
class FeatureMap {
 public:
  /// Pixels and channels.
  struct Shape {
    int height;
    int width;
    int channels;
    int border = 0;  ///< pixels on each side, which nobody writes
  };

  /// A map of zeros whose channels fill whole registers: those that are too many stay 0.
  explicit FeatureMap(const Shape& shape) : FeatureMap(shape, whole_lanes(shape.channels)) {}
  /// One whose channels take no more room than they need: what a network sees, in which most of a register
  /// would be zeros.
  static FeatureMap packed(const Shape& shape) { return {shape, shape.channels}; }
  /// A square one of a single channel.
  static FeatureMap of_image(int size, int border) { return packed({size, size, 1, border}); }

  int height() const { return shape_.height; }
  int width() const { return shape_.width; }
  int channels() const { return shape_.channels; }
  int border() const { return shape_.border; }
  /// Numbers from one pixel to the next: the channels, rounded up.
  int pixel_stride() const { return pixel_stride_; }
  /// Numbers from one row to the next.
  std::ptrdiff_t row_stride() const {
    return static_cast<std::ptrdiff_t>(shape_.width + 2 * shape_.border) * pixel_stride_;
  }

  /// The channels of a pixel; row and column may lie up to a border outside.
  float* pixel(int row, int column) { return values_.data() + place(row, column); }
  const float* pixel(int row, int column) const { return values_.data() + place(row, column); }

 private:
  FeatureMap(const Shape& shape, int pixel_stride)
      : shape_(shape),
        pixel_stride_(pixel_stride),
        values_(static_cast<std::size_t>(row_stride()) * (shape.height + 2 * shape.border)) {}

  std::ptrdiff_t place(int row, int column) const {
    return (row + shape_.border) * row_stride() +
           static_cast<std::ptrdiff_t>(column + shape_.border) * pixel_stride_;
  }

  Shape shape_;
  int pixel_stride_;
  AlignedVector values_;
};

}  // namespace knuckle
