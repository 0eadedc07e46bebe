// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "knuckle/core/image.h"
#include "knuckle/forest/depth_offsets.h"

namespace knuckle {

/// A depth image in 16 bits of which only squares with a measurement are kept: a person before an empty
/// background takes a third of the image's bytes, and a pixel is still read with two loads.
class DepthTiles {
 public:
  DepthTiles() = default;
  explicit DepthTiles(const Image<float>& depth_mm);

  int width() const { return width_; }
  int height() const { return height_; }
  /// The stored depth of a pixel; kFarDepth out of the image.
  std::int16_t operator()(int column, int row) const {
    // One tile of border all around takes whatever lies outside.
    const auto x = static_cast<std::size_t>(std::clamp(column, -1, width_) + kSide);
    const auto y = static_cast<std::size_t>(std::clamp(row, -1, height_) + kSide);
    const std::size_t tile = tiles_[y / kSide * tiles_a_row_ + x / kSide];
    return pixels_[tile * kSide * kSide + y % kSide * kSide + x % kSide];
  }

  std::size_t bytes() const;
  /// Depends on the pixels only.
  std::uint64_t hash() const;

 private:
  static constexpr int kSide = 8;

  int width_ = 0;
  int height_ = 0;
  std::size_t tiles_a_row_ = 0;
  std::vector<std::uint16_t> tiles_;  // where each tile's pixels lie; tile 0 holds nothing but kFarDepth
  std::vector<std::int16_t> pixels_;
};

}  // namespace knuckle
