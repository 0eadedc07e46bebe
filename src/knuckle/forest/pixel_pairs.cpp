// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pixel_pairs.h"

#include <algorithm>
#include <cstddef>

namespace knuckle {

namespace {

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
  std::vector<const std::int16_t*> rows;
  rows.reserve(samples.size());
  for (const std::uint32_t sample : samples) rows.push_back(samples_->features(sample));
  copy_rows(rows, row_length(block), loop, block);
}

void PixelPairFeatures::read_row(std::uint32_t sample, const Block& block, std::int16_t* row) const {
  std::copy_n(samples_->features(sample), row_length(block), row);
}

}  // namespace knuckle
