// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/feature_rows.h"

#include <array>

#include "knuckle/forest/simd.h"

namespace knuckle {

namespace {

constexpr std::size_t kTileSamples = FeatureRows::kTileSamples;
/// Side of the squares that are transposed in registers.
constexpr std::size_t kSide = 8;

/// Copies kTileSamples rows as columns; `target` is the place of the first row's first pixel.
void copy_tile(const std::array<const std::int16_t*, kTileSamples>& rows, std::size_t pixel_count,
               std::int16_t* target, std::size_t stride) {
  std::size_t pixel = 0;
  for (; pixel + kSide <= pixel_count; pixel += kSide) {
    for (std::size_t i = 0; i < kTileSamples; i += kSide) {
      transpose_8x8(rows.data() + i, static_cast<std::ptrdiff_t>(pixel), target + pixel * stride + i, stride);
    }
  }
  for (; pixel < pixel_count; ++pixel) {
    for (std::size_t i = 0; i < kTileSamples; ++i) target[pixel * stride + i] = rows[i][pixel];
  }
}

}  // namespace

void copy_rows(std::span<const std::int16_t* const> rows, std::size_t length,
               void (*loop)(std::int64_t count, const std::function<void(std::int64_t)>& work),
               FeatureRows& block) {
  block.resize(rows.size(), length);
  loop(static_cast<std::int64_t>(block.tile_count()), [&](std::int64_t tile) {
    const std::size_t first = static_cast<std::size_t>(tile) * kTileSamples;
    std::array<const std::int16_t*, kTileSamples> tile_rows;
    for (std::size_t i = 0; i < kTileSamples; ++i) {  // a tile that is not full repeats the last sample
      tile_rows[i] = rows[std::min(first + i, rows.size() - 1)];
    }
    copy_tile(tile_rows, block.row_count, block.tile(static_cast<std::size_t>(tile)), block.chunk_samples);
  });
}

}  // namespace knuckle
