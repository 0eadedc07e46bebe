// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/forest/feature_rows.h"
#include "knuckle/forest/split_options.h"
#include "knuckle/forest/training_samples.h"

namespace knuckle {

/// The split feature of equation 3: P(u1, v1) - P(u2, v2), two entries of a sample's row.
struct PixelPair {
  std::uint16_t first = 0;
  std::uint16_t second = 0;

  bool operator==(const PixelPair&) const = default;

  /// Shows the columns that a file keeps it in: calls visit(name, pointer to member).
  template <class Visit>
  static void for_each_column(Visit visit) {
    visit("node_first", &PixelPair::first);
    visit("node_second", &PixelPair::second);
  }
};

/// How the engine sees samples whose features are pixel differences: a model of the concept SplitFeatures.
class PixelPairFeatures {
 public:
  using Feature = PixelPair;

  using Candidate = PixelPair;
  /// The samples of a node, a row per pixel.
  using Block = FeatureRows;
  /// Calls its second argument for 0, ..., count - 1: parallel_for, or a plain loop.
  using Loop = void (*)(std::int64_t count, const std::function<void(std::int64_t)>& work);

  explicit PixelPairFeatures(const TrainingSamples& samples) : samples_(&samples) {}

  /// Candidate `index` of `count`. The first pixel is uniform over the index-th of `count` equal parts of the
  /// row (stratified, so that neighbouring candidates read neighbouring memory), the second over the whole
  /// row.
  PixelPair draw(Random& random, int index, int count) const;
  PixelPair draw(Random& random, int index, int count, const Block& /*block*/) const {
    return draw(random, index, count);
  }
  /// There is nothing to choose before samples are copied: every pixel is a row.
  void begin_node(Random& /*random*/, const TreeOptions& /*options*/, Block& /*block*/) const {}
  /// Copies these samples. `block` keeps its memory for the next call.
  void gather(std::span<const std::uint32_t> samples, Loop loop, Block& block) const;
  /// Numbers that the candidates of a node read of a sample, and those of one: what other workers are sent.
  std::size_t row_length(const Block& /*block*/) const {
    return static_cast<std::size_t>(samples_->feature_count());
  }
  void read_row(std::uint32_t sample, const Block& block, std::int16_t* row) const;
  static FeatureRows& rows_of(Block& block) { return block; }
  /// The feature of each sample of the block.
  static void values(const Block& block, PixelPair pair, std::int16_t* values) {
    block.difference({pair.first, pair.second}, values);
  }
  static PixelPair feature(const Block& /*block*/, PixelPair candidate) { return candidate; }
  /// Whether samples have what it reads.
  bool can_read(PixelPair pair) const {
    return pair.first < samples_->feature_count() && pair.second < samples_->feature_count();
  }
  /// The feature of one sample.
  std::int16_t value(std::uint32_t sample, PixelPair pair) const {
    const std::int16_t* row = samples_->features(sample);
    return static_cast<std::int16_t>(row[pair.first] - row[pair.second]);
  }

 private:
  const TrainingSamples* samples_;
};

}  // namespace knuckle
