// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pixel_pairs.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "knuckle/forest/simd.h"

namespace knuckle {

namespace {

/// Samples copied in one go: a row of them is a cache line of the block.
constexpr std::size_t kTileSamples = 32;
/// Most samples of a chunk: a row of 1 kB, so that the 9216 of a patch of 96 x 96 lie on 2304 pages of
/// memory.
constexpr std::size_t kChunkSamples = 512;
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
  const std::size_t tiles = (samples.size() + kTileSamples - 1) / kTileSamples;
  block.sample_count = samples.size();
  block.pixel_count = static_cast<std::size_t>(samples_->feature_count());
  block.chunk_samples = std::min(kChunkSamples, tiles * kTileSamples);
  const std::size_t chunks = (samples.size() + block.chunk_samples - 1) / block.chunk_samples;
  const std::size_t size = chunks * block.pixel_count * block.chunk_samples;
  if (block.pixels.size() < size) block.pixels.resize(size);
  loop(static_cast<std::int64_t>(tiles), [&](std::int64_t tile) {
    const std::size_t first = static_cast<std::size_t>(tile) * kTileSamples;
    std::array<const std::int16_t*, kTileSamples> rows;
    for (std::size_t i = 0; i < kTileSamples; ++i) {  // a tile that is not full repeats the last sample
      rows[i] = samples_->features(samples[std::min(first + i, samples.size() - 1)]);
    }
    const std::size_t chunk = first / block.chunk_samples;
    std::int16_t* target =
        block.pixels.data() + chunk * block.pixel_count * block.chunk_samples + first % block.chunk_samples;
    copy_tile(rows, block.pixel_count, target, block.chunk_samples);
  });
}

void PixelPairFeatures::values(const Block& block, PixelPair pair, std::int16_t* values) {
  const std::int16_t* chunk = block.pixels.data();
  for (std::size_t done = 0; done < block.sample_count; done += block.chunk_samples) {
    const std::int16_t* first = chunk + pair.first * block.chunk_samples;
    const std::int16_t* second = chunk + pair.second * block.chunk_samples;
    const std::size_t count = std::min(block.chunk_samples, block.sample_count - done);
    for (std::size_t i = 0; i < count; ++i)
      values[done + i] = static_cast<std::int16_t>(first[i] - second[i]);
    chunk += block.pixel_count * block.chunk_samples;
  }
}

}  // namespace knuckle
