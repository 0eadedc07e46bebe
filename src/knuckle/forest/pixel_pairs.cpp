// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pixel_pairs.h"

#include <algorithm>
#include <cstddef>

namespace knuckle {

namespace {

/// Samples copied at once: a row of them is half a cache line of the destination.
constexpr std::size_t kTileSamples = 16;
/// Pixels copied at once: a cache line of the source.
constexpr std::size_t kTilePixels = 32;

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
  const auto pixel_count = static_cast<std::size_t>(samples_->feature_count());
  const std::size_t tiles = (samples.size() + kTileSamples - 1) / kTileSamples;
  block.sample_count = samples.size();
  block.stride = tiles * kTileSamples;
  if (block.pixels.size() < block.stride * pixel_count) block.pixels.resize(block.stride * pixel_count);
  loop(static_cast<std::int64_t>(tiles), [&](std::int64_t tile) {
    const std::size_t first = static_cast<std::size_t>(tile) * kTileSamples;
    const std::int16_t* rows[kTileSamples];
    for (std::size_t i = 0; i < kTileSamples; ++i) {  // a tile that is not full repeats the last sample
      rows[i] = samples_->features(samples[std::min(first + i, samples.size() - 1)]);
    }
    for (std::size_t start = 0; start < pixel_count; start += kTilePixels) {
      const std::size_t end = std::min(start + kTilePixels, pixel_count);
      for (std::size_t pixel = start; pixel < end; ++pixel) {
        std::int16_t* target = block.pixels.data() + pixel * block.stride + first;
        for (std::size_t i = 0; i < kTileSamples; ++i) target[i] = rows[i][pixel];
      }
    }
  });
}

void PixelPairFeatures::values(const Block& block, PixelPair pair, std::int16_t* values) {
  const std::int16_t* first = block.pixels.data() + pair.first * block.stride;
  const std::int16_t* second = block.pixels.data() + pair.second * block.stride;
  for (std::size_t i = 0; i < block.sample_count; ++i) {
    values[i] = static_cast<std::int16_t>(first[i] - second[i]);
  }
}

}  // namespace knuckle
