// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/forest/depth_offsets.h"
#include "knuckle/forest/feature_rows.h"
#include "knuckle/forest/pixel_samples.h"
#include "knuckle/forest/split_options.h"

namespace knuckle {

/// How the engine sees pixels whose features are differences of depth probes: a model of the concept
/// SplitFeatures.
///
/// A node draws a pool of offsets; each sample reads the depth at each of them once, and every candidate is
/// the difference of two of those readings, contiguous in memory. A pool of 256 has 32,640 pairs: 10^4
/// candidates are different pairs, but share 256 probes instead of having 20,000 of their own. Offset 0 of
/// the pool is (0, 0), and the first candidates are all the others less that one: equation 1 as printed.
class OffsetFeatures {
 public:
  using Feature = OffsetPair;
  using Candidate = RowPair;
  /// Calls its second argument for 0, ..., count - 1: parallel_for, or a plain loop.
  using Loop = void (*)(std::int64_t count, const std::function<void(std::int64_t)>& work);

  /// The depths that a node's samples read, a row per offset of its pool.
  struct Block {
    FeatureRows rows;
    std::vector<DepthOffset> pool;
  };

  OffsetFeatures(const PixelSamples& images, const ArrangedSamples& samples, const OffsetOptions& options)
      : images_(images.images()), samples_(samples.samples), options_(options) {}

  /// Draws the node's pool.
  void begin_node(Random& random, const TreeOptions& options, Block& block) const;
  /// Reads the samples' depths.
  void gather(std::span<const std::uint32_t> samples, Loop loop, Block& block) const;
  /// Numbers that the candidates of a node read of a sample, and those of one: what other workers are sent.
  static std::size_t row_length(const Block& block) { return block.pool.size(); }
  void read_row(std::uint32_t sample, const Block& block, std::int16_t* row) const;
  static FeatureRows& rows_of(Block& block) { return block.rows; }
  /// Candidate `index`: offset index + 1 less offset 0, then random pairs.
  RowPair draw(Random& random, int index, int count, const Block& block) const;
  static void values(const Block& block, RowPair pair, std::int16_t* values) {
    block.rows.difference(pair, values);
  }
  static OffsetPair feature(const Block& block, RowPair pair) {
    const DepthOffset& first = block.pool[pair.first];
    const DepthOffset& second = block.pool[pair.second];
    return {first.x, first.y, second.x, second.y};
  }
  /// Whether it reads within the offsets that there are.
  static bool can_read(const OffsetPair& pair) {
    const auto is_offset = [](int offset) { return offset >= -kMostOffset && offset <= kMostOffset; };
    return is_offset(pair.first_x) && is_offset(pair.first_y) && is_offset(pair.second_x) &&
           is_offset(pair.second_y);
  }
  /// The feature of one sample.
  std::int16_t value(std::uint32_t sample, const OffsetPair& pair) const {
    const auto& [index, column, row] = samples_[sample];
    const PixelSamples::DepthImage& image = images_[index];
    return offset_feature(image.depth, column, row, image.scale.at(image.depth(column, row)), pair);
  }

 private:
  /// Reads a sample's depths at the offsets of a pool, into every `stride`-th number.
  void read(std::uint32_t sample, std::span<const DepthOffset> pool, std::int16_t* target,
            std::size_t stride) const;

  std::span<const PixelSamples::DepthImage> images_;
  std::span<const ArrangedSamples::Sample> samples_;
  OffsetOptions options_;
};

}  // namespace knuckle
