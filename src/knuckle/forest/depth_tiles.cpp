// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/depth_tiles.h"

#include <array>
#include <limits>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/forest/mixed_hash.h"

namespace knuckle {

DepthTiles::DepthTiles(const Image<float>& depth_mm) : width_(depth_mm.width()), height_(depth_mm.height()) {
  constexpr std::size_t kPixels = std::size_t{kSide} * kSide;
  const int columns = (width_ + kSide - 1) / kSide;
  const int rows = (height_ + kSide - 1) / kSide;
  if (columns * rows > std::numeric_limits<std::uint16_t>::max()) {
    fail("depth image of {} x {} pixels: too large to train a forest on", width_, height_);
  }
  tiles_per_row_ = columns + 2;
  tiles_.resize(static_cast<std::size_t>(tiles_per_row_) * (rows + 2));
  pixels_.assign(kPixels, kFarDepth);
  for (int top = 0; top < rows; ++top) {
    for (int left = 0; left < columns; ++left) {
      std::array<std::int16_t, kPixels> tile;
      tile.fill(kFarDepth);
      bool is_empty = true;
      for (int y = 0; y < std::min(kSide, height_ - top * kSide); ++y) {
        for (int x = 0; x < std::min(kSide, width_ - left * kSide); ++x) {
          const std::int16_t depth = stored_depth(depth_mm(left * kSide + x, top * kSide + y));
          tile[static_cast<std::size_t>(y) * kSide + x] = depth;
          is_empty = is_empty && depth == kFarDepth;
        }
      }
      if (is_empty) continue;
      tiles_[static_cast<std::size_t>(top + 1) * tiles_per_row_ + left + 1] =
          static_cast<std::uint16_t>(pixels_.size() / kPixels);
      pixels_.insert(pixels_.end(), tile.begin(), tile.end());
    }
  }
  pixels_.shrink_to_fit();
}

std::size_t DepthTiles::bytes() const {
  return sizeof(DepthTiles) + tiles_.size() * sizeof(tiles_[0]) + pixels_.size() * sizeof(pixels_[0]);
}

std::size_t DepthTiles::message_bytes() const {
  return sizeof(Lengths) + tiles_.size() * sizeof(tiles_[0]) + pixels_.size() * sizeof(pixels_[0]);
}

void DepthTiles::append_to(std::vector<std::byte>& message) const {
  append_value(message,
               Lengths{.width = width_, .height = height_, .tiles = tiles_.size(), .pixels = pixels_.size()});
  append_values(message, std::span<const std::uint16_t>(tiles_));
  append_values(message, std::span<const std::int16_t>(pixels_));
}

DepthTiles DepthTiles::read(MessageReader& reader) {
  constexpr std::uint64_t kPixels = std::uint64_t{kSide} * kSide;
  const auto lengths = reader.value<Lengths>();
  const auto tiles_along = [](std::int64_t pixels) { return (pixels + kSide - 1) / kSide + 2; };
  const auto is_side = [](std::int32_t pixels) { return pixels >= 0 && pixels <= limits::kImageSide; };
  const bool fits = is_side(lengths.width) && is_side(lengths.height) &&
                    lengths.tiles == static_cast<std::uint64_t>(tiles_along(lengths.width)) *
                                         static_cast<std::uint64_t>(tiles_along(lengths.height)) &&
                    lengths.tiles <= reader.bytes_left() && lengths.pixels <= reader.bytes_left() &&
                    lengths.pixels >= kPixels && lengths.pixels % kPixels == 0;
  if (!fits) fail("a worker's message: a depth image whose sizes do not fit together");
  DepthTiles image;
  image.width_ = lengths.width;
  image.height_ = lengths.height;
  image.tiles_per_row_ = static_cast<std::int32_t>(tiles_along(lengths.width));
  image.tiles_.resize(lengths.tiles);
  image.pixels_.resize(lengths.pixels);
  reader.read(std::span(image.tiles_));
  reader.read(std::span(image.pixels_));
  for (const std::uint16_t tile : image.tiles_) {
    if (tile >= lengths.pixels / kPixels) fail("a worker's message: a depth image has no tile {}", tile);
  }
  for (const std::int16_t depth : image.pixels_) {
    if (depth < 1 || depth > kFarDepth) fail("a worker's message: a depth of {} mm", depth);
  }
  return image;
}

std::uint64_t DepthTiles::hash() const {
  std::uint64_t hash = mixed_hash(static_cast<std::uint64_t>(width_), static_cast<std::uint64_t>(height_));
  for (const std::uint16_t tile : tiles_) hash = mixed_hash(hash, tile);
  for (const std::int16_t pixel : pixels_) hash = mixed_hash(hash, static_cast<std::uint16_t>(pixel));
  return hash;
}

}  // namespace knuckle
