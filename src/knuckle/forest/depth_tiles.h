// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "knuckle/core/image.h"
#include "knuckle/core/worker_messages.h"
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
  std::int16_t operator()(int column, int row) const { return at(place_of(column, row)); }

  /// A place to read, parted in what can be computed for many at once and what must be looked up.
  struct Place {
    std::int32_t tile = 0;   ///< of the table
    std::int32_t pixel = 0;  ///< in the tile
  };
  /// operator() is at(place_of(column, row)).
  Place place_of(int column, int row) const {
    // One tile of border all around takes whatever lies outside.
    const int x = std::clamp(column, -1, width_) + kSide;
    const int y = std::clamp(row, -1, height_) + kSide;
    return {(y >> kSideBits) * tiles_per_row_ + (x >> kSideBits),
            ((y & (kSide - 1)) << kSideBits) + (x & (kSide - 1))};
  }
  std::int16_t at(Place place) const {
    const std::size_t tile = tiles_[static_cast<std::size_t>(place.tile)];
    return pixels_[tile * kSide * kSide + static_cast<std::size_t>(place.pixel)];
  }

  std::size_t bytes() const;
  /// Bytes of the image in a message to another worker, and the message.
  std::size_t message_bytes() const;
  void append_to(std::vector<std::byte>& message) const;
  /// Reads what append_to wrote. Throws an Error where a tile leads nowhere or sizes do not fit together.
  static DepthTiles read(MessageReader& reader);
  /// Depends on the pixels only.
  std::uint64_t hash() const;

 private:
  /// The lengths that a message begins with.
  struct Lengths {
    std::int32_t width = 0;
    std::int32_t height = 0;
    std::uint64_t tiles = 0;
    std::uint64_t pixels = 0;
  };

  static constexpr int kSideBits = 3;
  static constexpr int kSide = 1 << kSideBits;

  int width_ = 0;
  int height_ = 0;
  std::int32_t tiles_per_row_ = 0;
  std::vector<std::uint16_t> tiles_;  // where each tile's pixels lie; tile 0 holds nothing but kFarDepth
  std::vector<std::int16_t> pixels_;
};

}  // namespace knuckle
