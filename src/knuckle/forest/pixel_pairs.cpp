// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pixel_pairs.h"

#include <algorithm>
#include <array>
#include <cstddef>

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

/// The word as a fraction of 2^32 of `count`: uniform over 0, ..., count - 1 up to count / 2^32.
std::uint64_t scaled(std::uint32_t word, std::uint64_t count) {
  return (word * count) >> 32U;
}

}  // namespace

PixelPair PixelPairFeatures::draw(Random& random, int index, int count) const {
  const auto pixels = static_cast<std::uint64_t>(samples_->feature_count());
  const std::uint64_t place =
      (static_cast<std::uint64_t>(index) << 32U) + random();  // in units of 2^-32 candidates
  const std::uint64_t first = (place / static_cast<std::uint64_t>(count) * pixels) >> 32U;
  return {static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(scaled(random(), pixels))};
}

void PixelPairFeatures::gather(std::span<const std::uint32_t> samples, Loop loop, Block& block) const {
  block.resize(samples.size(), static_cast<std::size_t>(samples_->feature_count()));
  loop(static_cast<std::int64_t>(block.tile_count()), [&](std::int64_t tile) {
    const std::size_t first = static_cast<std::size_t>(tile) * kTileSamples;
    std::array<const std::int16_t*, kTileSamples> rows;
    for (std::size_t i = 0; i < kTileSamples; ++i) {  // a tile that is not full repeats the last sample
      rows[i] = samples_->features(samples[std::min(first + i, samples.size() - 1)]);
    }
    copy_tile(rows, block.row_count, block.tile(static_cast<std::size_t>(tile)), block.chunk_samples);
  });
}

}  // namespace knuckle
