// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "knuckle/forest/scoring_targets.h"
#include "knuckle/forest/simd.h"

namespace knuckle {

/// The best way to part binned samples: those in bin `bin` or above it go right. `bin` is 0 where none is
/// good.
struct BinSplit {
  int bin = 0;
  float gain = 0.0F;  ///< in the statistics' own unit; above 0 where the split is any good
};

/// The reduction of the targets' summed variance, a model of the concept SplitStatistics.
///
/// With n samples of sum S in the node, of which n_l of sum S_l go left and n_r right, the sum of squared
/// distances to the mean falls by exactly
///     gain = |S_l - n_l S / n|^2 * n / (n_l n_r)
/// over all dimensions (the between-group sum of squares). Only S_l depends on the split, and it is a prefix
/// sum over a histogram of bins. kLanes - 1 is the number of dimensions; lane 0 holds the constant 1 and so
/// counts the samples.
template <int kLanes>
class VarianceStatistics {
  static_assert(kLanes % kSimdLanes == 0, "whole SIMD registers");
  static constexpr std::size_t kRegisters = kLanes / kSimdLanes;

 public:
  static constexpr int kMostDimensions = kLanes - 1;
  static constexpr int kMostBins = 256;

  /// One sum of rows for each bin.
  struct Histogram {
    std::array<std::array<Int32x8, kRegisters>, kMostBins> sums;
  };

  /// The targets of one node's samples, ready for scoring. At most 65535 of them: sums then fit 32 bits.
  class Node {
   public:
    /// Copies the rows and centres them on their rounded mean.
    void assign(const ScoringTargets& targets, std::span<const std::uint32_t> samples);
    /// `bins` has the bin of each sample, below `bin_count`. Only splits with at least `min_samples` on both
    /// sides.
    BinSplit best_split(const std::uint8_t* bins, int bin_count, int min_samples, Histogram& histogram) const;

   private:
    float gain(const std::array<Int32x8, kRegisters>& left) const;

    std::size_t count_ = 0;
    std::vector<std::array<Int32x8, kRegisters>> rows_;  // one a sample; lane 0 is 1, unused lanes are 0
    std::array<Float32x8, kRegisters> mean_{};           // what the rounding of the mean left; 1 in lane 0
    std::vector<float> weight_;                          // n / (n_l n_r) for each n_l
  };

  explicit VarianceStatistics(const ScoringTargets& targets) : targets_(&targets) {}
  void assign(std::span<const std::uint32_t> samples, Node& node) const { node.assign(*targets_, samples); }

 private:
  const ScoringTargets* targets_;
};

template <int kLanes>
void VarianceStatistics<kLanes>::Node::assign(const ScoringTargets& targets,
                                              std::span<const std::uint32_t> samples) {
  count_ = samples.size();
  const auto count = static_cast<std::int64_t>(count_);
  std::array<std::int64_t, kLanes> sum{};
  for (const std::uint32_t sample : samples) {
    const std::int16_t* row = targets.row(sample);
    for (int d = 0; d < targets.dimensions; ++d) sum[static_cast<std::size_t>(d)] += row[d];
  }
  std::array<std::int32_t, kLanes> centre{};
  std::array<float, kLanes> mean{1.0F};
  for (int d = 0; d < targets.dimensions; ++d) {
    const std::int64_t total = sum[static_cast<std::size_t>(d)];
    const std::int64_t rounded = total / count;
    centre[static_cast<std::size_t>(d)] = static_cast<std::int32_t>(rounded);
    mean[static_cast<std::size_t>(d) + 1] =
        static_cast<float>(total - rounded * count) / static_cast<float>(count);
  }
  std::memcpy(mean_.data(), mean.data(), sizeof(mean));
  rows_.resize(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    const std::int16_t* row = targets.row(samples[i]);
    std::array<std::int32_t, kLanes> centred{1};
    for (int d = 0; d < targets.dimensions; ++d) {
      centred[static_cast<std::size_t>(d) + 1] = row[d] - centre[static_cast<std::size_t>(d)];
    }
    std::memcpy(&rows_[i], centred.data(), sizeof(centred));
  }
  weight_.assign(count_ + 1, 0.0F);
  for (std::size_t left = 1; left < count_; ++left) {
    weight_[left] = static_cast<float>(static_cast<double>(count) /
                                       (static_cast<double>(left) * static_cast<double>(count_ - left)));
  }
}

template <int kLanes>
float VarianceStatistics<kLanes>::Node::gain(const std::array<Int32x8, kRegisters>& left) const {
  const std::int32_t count = left[0][0];
  Float32x8 squares{};
  for (std::size_t i = 0; i < kRegisters; ++i) {
    const Float32x8 deviation = to_float(left[i]) - static_cast<float>(count) * mean_[i];  // 0 in lane 0
    squares += deviation * deviation;
  }
  return lane_sum(squares) * weight_[static_cast<std::size_t>(count)];
}

template <int kLanes>
BinSplit VarianceStatistics<kLanes>::Node::best_split(const std::uint8_t* bins, int bin_count,
                                                      int min_samples, Histogram& histogram) const {
  std::fill_n(histogram.sums.begin(), bin_count, std::array<Int32x8, kRegisters>{});
  for (std::size_t i = 0; i < count_; ++i) {
    std::array<Int32x8, kRegisters>& sum = histogram.sums[bins[i]];
    for (std::size_t r = 0; r < kRegisters; ++r) sum[r] += rows_[i][r];
  }
  BinSplit best;
  const auto most_left = static_cast<std::int32_t>(count_) - min_samples;
  std::array<Int32x8, kRegisters> left{};
  for (int bin = 0; bin + 1 < bin_count; ++bin) {
    const std::array<Int32x8, kRegisters>& sum = histogram.sums[static_cast<std::size_t>(bin)];
    if (sum[0][0] == 0) continue;  // the same split as the one before
    for (std::size_t r = 0; r < kRegisters; ++r) left[r] += sum[r];
    if (left[0][0] < min_samples) continue;
    if (left[0][0] > most_left) break;
    const float gained = gain(left);
    if (gained > best.gain) best = {bin + 1, gained};
  }
  return best;
}

}  // namespace knuckle
