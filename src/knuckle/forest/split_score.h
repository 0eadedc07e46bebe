// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/forest/scoring_targets.h"

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
  static_assert(kLanes % 8 == 0, "whole SIMD registers");

 public:
  static constexpr int kMostDimensions = kLanes - 1;
  static constexpr int kMostBins = 256;

  /// One sum of rows for each bin.
  struct Histogram {
    std::array<std::int32_t, static_cast<std::size_t>(kLanes) * kMostBins> sums;
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
    float gain(const std::int32_t* left) const;

    std::size_t count_ = 0;
    std::vector<std::int16_t> rows_;    // count_ x kLanes; lane 0 is 1, unused lanes are 0
    std::array<float, kLanes> mean_{};  // what the rounding of the mean left; 1 in lane 0
    std::vector<float> weight_;         // n / (n_l n_r) for each n_l
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
  std::array<std::int16_t, kLanes> centre{};
  mean_.fill(0.0F);
  mean_[0] = 1.0F;
  for (int d = 0; d < targets.dimensions; ++d) {
    const std::int64_t total = sum[static_cast<std::size_t>(d)];
    const std::int64_t rounded = total / count;
    centre[static_cast<std::size_t>(d)] = static_cast<std::int16_t>(rounded);
    mean_[static_cast<std::size_t>(d) + 1] =
        static_cast<float>(total - rounded * count) / static_cast<float>(count);
  }
  rows_.assign(count_ * kLanes, 0);
  std::int16_t* target = rows_.data();
  for (const std::uint32_t sample : samples) {
    const std::int16_t* row = targets.row(sample);
    target[0] = 1;
    for (int d = 0; d < targets.dimensions; ++d) {
      target[d + 1] = static_cast<std::int16_t>(row[d] - centre[static_cast<std::size_t>(d)]);
    }
    target += kLanes;
  }
  weight_.assign(count_ + 1, 0.0F);
  for (std::size_t left = 1; left < count_; ++left) {
    weight_[left] = static_cast<float>(static_cast<double>(count) /
                                       (static_cast<double>(left) * static_cast<double>(count_ - left)));
  }
}

template <int kLanes>
float VarianceStatistics<kLanes>::Node::gain(const std::int32_t* left) const {
  const auto count = static_cast<float>(left[0]);
  std::array<float, 8> squares{};
  for (std::size_t lane = 0; lane < kLanes; lane += 8) {
    for (std::size_t i = 0; i < 8; ++i) {
      const float deviation = static_cast<float>(left[lane + i]) - count * mean_[lane + i];  // 0 in lane 0
      squares[i] += deviation * deviation;
    }
  }
  const float sum = ((squares[0] + squares[4]) + (squares[2] + squares[6])) +
                    ((squares[1] + squares[5]) + (squares[3] + squares[7]));
  return sum * weight_[static_cast<std::size_t>(left[0])];
}

template <int kLanes>
BinSplit VarianceStatistics<kLanes>::Node::best_split(const std::uint8_t* bins, int bin_count,
                                                      int min_samples, Histogram& histogram) const {
  std::int32_t* const sums = histogram.sums.data();
  std::fill_n(sums, static_cast<std::size_t>(bin_count) * kLanes, 0);
  const std::int16_t* row = rows_.data();
  for (std::size_t i = 0; i < count_; ++i, row += kLanes) {
    std::int32_t* __restrict const sum = sums + static_cast<std::size_t>(bins[i]) * kLanes;
    for (int lane = 0; lane < kLanes; ++lane) sum[lane] += row[lane];
  }
  BinSplit best;
  const auto most_left = static_cast<std::int32_t>(count_) - min_samples;
  std::array<std::int32_t, kLanes> left{};
  for (int bin = 0; bin + 1 < bin_count; ++bin) {
    const std::int32_t* const sum = sums + static_cast<std::size_t>(bin) * kLanes;
    if (sum[0] == 0) continue;  // the same split as the one before
    for (std::size_t lane = 0; lane < kLanes; ++lane) left[lane] += sum[lane];
    if (left[0] < min_samples) continue;
    if (left[0] > most_left) break;
    const float gained = gain(left.data());
    if (gained > best.gain) best = {bin + 1, gained};
  }
  return best;
}

}  // namespace knuckle
