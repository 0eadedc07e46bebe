// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/offset_features.h"

#include <algorithm>
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
    std::vector<DepthTiles::Place> places(block.pool.size());
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [index, column, row] = samples_[samples[first + i]];
      const PixelSamples::DepthImage& image = images_[index];
      const PixelScale scale = image.scale.at(image.depth(column, row));
      for (std::size_t p = 0; p < places.size(); ++p) {  // arithmetic only: vectorises
        const DepthOffset& offset = block.pool[p];
        places[p] = image.depth.place_of(shifted(column, offset.x, scale.x), shifted(row, offset.y, scale.y));
      }
      std::int16_t* value = target + i;
      for (const DepthTiles::Place& place : places) {
        *value = image.depth.at(place);
        value += block.rows.chunk_samples;
      }
    }
  });
}

void OffsetFeatures::read_row(std::uint32_t sample, const Block& block, std::int16_t* row) const {
  const auto& [index, column, line] = samples_[sample];
  const PixelSamples::DepthImage& image = images_[index];
  const PixelScale scale = image.scale.at(image.depth(column, line));
  for (const DepthOffset& offset : block.pool) {
    *row++ = image.depth.at(
        image.depth.place_of(shifted(column, offset.x, scale.x), shifted(line, offset.y, scale.y)));
  }
}

}  // namespace knuckle
