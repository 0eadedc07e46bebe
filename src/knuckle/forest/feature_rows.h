// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace knuckle {

/// Two rows of FeatureRows: the candidate feature is the first less the second.
struct RowPair {
  std::uint16_t first = 0;
  std::uint16_t second = 0;
};

/// What the candidates of a node read of its samples: a row of numbers for each quantity, a column for each
/// sample, in chunks of `chunk_samples`. Row r of the i-th sample of chunk c lies at
/// (c * row_count + r) * chunk_samples + i, so that a candidate is the difference of two contiguous rows, and
/// a chunk spans few enough memory pages to be written fast.
struct FeatureRows {
  /// Samples copied in one go: a row of them is a cache line.
  static constexpr std::size_t kTileSamples = 32;
  /// Most samples of a chunk: a row of 1 kB, so that the 9216 pixels of a patch of 96 x 96 lie on 2304 pages.
  static constexpr std::size_t kChunkSamples = 512;

  std::size_t sample_count = 0;
  std::size_t row_count = 0;
  std::size_t chunk_samples = 0;
  std::vector<std::int16_t> values;

  /// Makes room; what it held is lost.
  void resize(std::size_t samples, std::size_t rows) {
    sample_count = samples;
    row_count = rows;
    chunk_samples = std::min(kChunkSamples, tile_count() * kTileSamples);
    const std::size_t chunks = (samples + chunk_samples - 1) / chunk_samples;
    if (values.size() < chunks * rows * chunk_samples) values.resize(chunks * rows * chunk_samples);
  }

  std::size_t tile_count() const { return (sample_count + kTileSamples - 1) / kTileSamples; }

  /// The place of row 0 of a tile's first sample; row r lies r * chunk_samples after it.
  std::int16_t* tile(std::size_t tile) {
    const std::size_t first = tile * kTileSamples;
    return values.data() + first / chunk_samples * row_count * chunk_samples + first % chunk_samples;
  }

  /// The difference of two rows for every sample, into `out` (sample_count entries).
  void difference(RowPair pair, std::int16_t* out) const {
    const std::int16_t* chunk = values.data();
    for (std::size_t done = 0; done < sample_count; done += chunk_samples) {
      const std::int16_t* first = chunk + pair.first * chunk_samples;
      const std::int16_t* second = chunk + pair.second * chunk_samples;
      const std::size_t count = std::min(chunk_samples, sample_count - done);
      for (std::size_t i = 0; i < count; ++i) out[done + i] = static_cast<std::int16_t>(first[i] - second[i]);
      chunk += row_count * chunk_samples;
    }
  }
};

/// Fills the block with samples of `length` numbers each: sample i lies at rows[i]. `loop` calls its second
/// argument for 0, ..., count - 1: parallel_for, or a plain loop.
void copy_rows(std::span<const std::int16_t* const> rows, std::size_t length,
               void (*loop)(std::int64_t count, const std::function<void(std::int64_t)>& work),
               FeatureRows& block);

}  // namespace knuckle
