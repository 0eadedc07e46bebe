// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/forest/training_samples.h"

namespace knuckle {

/// The split feature of equation 3: P(u1, v1) - P(u2, v2), two entries of a sample's row.
struct PixelPair {
  std::uint16_t first = 0;
  std::uint16_t second = 0;

  bool operator==(const PixelPair&) const = default;
};

/// How the engine sees samples whose features are pixel differences: a model of the concept SplitFeatures.
class PixelPairFeatures {
 public:
  using Feature = PixelPair;

  /// A copy of some samples, in chunks of `chunk_samples`, each pixel-major: pixel p of the i-th sample of
  /// chunk c lies at (c * pixel_count + p) * chunk_samples + i. The values of a candidate are then the
  /// difference of two contiguous rows, and a chunk spans few enough memory pages to be written fast.
  struct Block {
    std::size_t sample_count = 0;
    std::size_t pixel_count = 0;
    std::size_t chunk_samples = 0;
    std::vector<std::int16_t> pixels;
  };
  /// Calls its second argument for 0, ..., count - 1: parallel_for, or a plain loop.
  using Loop = void (*)(std::int64_t count, const std::function<void(std::int64_t)>& work);

  explicit PixelPairFeatures(const TrainingSamples& samples) : samples_(&samples) {}

  /// Candidate `index` of `count`. The first pixel is uniform over the index-th of `count` equal parts of the
  /// row (stratified, so that neighbouring candidates read neighbouring memory), the second over the whole
  /// row.
  PixelPair draw(Random& random, int index, int count) const;
  /// Copies these samples. `block` keeps its memory for the next call.
  void gather(std::span<const std::uint32_t> samples, Loop loop, Block& block) const;
  /// The feature of each sample of the block.
  static void values(const Block& block, PixelPair pair, std::int16_t* values);
  /// The feature of one sample.
  std::int16_t value(std::uint32_t sample, PixelPair pair) const {
    const std::int16_t* row = samples_->features(sample);
    return static_cast<std::int16_t>(row[pair.first] - row[pair.second]);
  }

 private:
  const TrainingSamples* samples_;
};

}  // namespace knuckle
