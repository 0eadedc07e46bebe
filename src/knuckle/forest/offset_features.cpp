// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/offset_features.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace knuckle {

void OffsetFeatures::begin_node(Random& random, const TreeOptions& options, Block& block) const {
  // No more offsets than candidates could use.
  const int size = std::min(options_.offsets_per_node, options.splits_per_node + 1);
  block.pool.assign(1, DepthOffset{});
  while (std::ssize(block.pool) < size) block.pool.push_back(drawn_offset(options_, random));
}

RowPair OffsetFeatures::draw(Random& random, int index, int /*count*/, const Block& block) const {
  const auto offsets = static_cast<std::uint32_t>(block.pool.size());
  if (index + 1 < static_cast<int>(offsets)) return {static_cast<std::uint16_t>(index + 1), 0};
  const std::uint32_t first = 1 + random.below(offsets - 1);
  std::uint32_t second = random.below(offsets - 1);  // any other
  if (second >= first) ++second;
  return {static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(second)};
}

void OffsetFeatures::gather(std::span<const std::uint32_t> samples, Loop loop, Block& block) const {
  constexpr std::size_t kTileSamples = FeatureRows::kTileSamples;
  block.rows.resize(samples.size(), block.pool.size());
  loop(static_cast<std::int64_t>(block.rows.tile_count()), [&](std::int64_t tile) {
    const std::size_t first = static_cast<std::size_t>(tile) * kTileSamples;
    const std::size_t count = std::min(kTileSamples, samples.size() - first);
    std::int16_t* const target = block.rows.tile(static_cast<std::size_t>(tile));
    for (std::size_t i = 0; i < count; ++i) {
      read(samples[first + i], block.pool, target + i, block.rows.chunk_samples);
    }
  });
}

void OffsetFeatures::read_row(std::uint32_t sample, const Block& block, std::int16_t* row) const {
  read(sample, block.pool, row, 1);
}

void OffsetFeatures::read(std::uint32_t sample, std::span<const DepthOffset> pool, std::int16_t* target,
                          std::size_t stride) const {
  const auto& [index, column, row] = samples_[sample];
  const PixelSamples::DepthImage& image = images_[index];
  const PixelScale scale = image.scale.at(image.depth(column, row));
  constexpr std::size_t kAtOnce = 64;
  std::array<DepthTiles::Place, kAtOnce> places;
  for (std::size_t first = 0; first < pool.size(); first += kAtOnce) {
    const auto offsets = pool.subspan(first, std::min(kAtOnce, pool.size() - first));
    for (std::size_t p = 0; p < offsets.size(); ++p) {  // arithmetic only: vectorises
      places[p] =
          image.depth.place_of(shifted(column, offsets[p].x, scale.x), shifted(row, offsets[p].y, scale.y));
    }
    for (std::size_t p = 0; p < offsets.size(); ++p) {
      *target = image.depth.at(places[p]);
      target += stride;
    }
  }
}

}  // namespace knuckle
