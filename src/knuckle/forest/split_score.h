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
#include "knuckle/forest/split_options.h"
#include "knuckle/forest/value_bins.h"

namespace knuckle {

/// The best threshold for a candidate feature: samples with a value of at least `threshold` go right.
struct ThresholdSplit {
  std::int16_t threshold = 0;
  float gain = 0.0F;  ///< in the statistics' own unit; above 0 where the split is any good
};

/// Bins that a candidate's values are parted into in a node of `samples` scored samples: half as many as
/// samples, so that the cost of a small node falls with its size, and at most options.threshold_bins.
inline int bins_for(const TreeOptions& options, std::size_t samples) {
  return static_cast<int>(
      std::clamp<std::size_t>(samples / 2, 2, static_cast<std::size_t>(options.threshold_bins)));
}

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

  /// Working memory of one thread: the bin of each sample, and one sum of rows for each bin.
  struct Scratch {
    std::vector<std::uint8_t> bins;
    std::array<std::array<Int32x8, kRegisters>, kMostBins> sums;
  };

  /// The targets of one node's samples, ready for scoring. At most 65535 of them: sums then fit 32 bits.
  class Node {
   public:
    /// Copies the rows and centres them on their rounded mean.
    void assign(const ScoringTargets& targets, std::span<const std::uint32_t> samples);
    /// The samples in the order in which best_split takes their values.
    std::span<const std::uint32_t> samples() const { return samples_; }
    /// True where no split can gain anything. Not looked for here: such nodes are rare.
    static bool is_pure() { return false; }
    /// The best of the thresholds between bins of equal width (ValueBins). Only splits with at least
    /// options.min_leaf_samples on both sides.
    ThresholdSplit best_split(std::span<const std::int16_t> values, std::size_t candidate,
                              const TreeOptions& options, Scratch& scratch) const;

   private:
    /// The best of binned samples: the first bin that goes right, 0 where none is good.
    struct BinSplit {
      int bin = 0;
      float gain = 0.0F;
    };
    BinSplit best_bin(int bin_count, int min_samples, Scratch& scratch) const;
    float gain(const std::array<Int32x8, kRegisters>& left) const;

    std::size_t count_ = 0;
    std::span<const std::uint32_t> samples_;
    std::vector<std::array<Int32x8, kRegisters>> rows_;  // one per sample; lane 0 is 1, unused lanes are 0
    std::array<Float32x8, kRegisters> mean_{};           // what the rounding of the mean left; 1 in lane 0
    std::vector<float> weight_;                          // n / (n_l n_r) for each n_l
  };

  explicit VarianceStatistics(const ScoringTargets& targets) : targets_(&targets) {}
  void assign(std::span<const std::uint32_t> samples, Node& node) const { node.assign(*targets_, samples); }

  /// The targets of one sample, and statistics of samples that came from other workers.
  std::size_t target_length() const { return static_cast<std::size_t>(targets_->dimensions); }
  void read_target(std::uint32_t sample, std::int16_t* target) const {
    std::copy_n(targets_->row(sample), target_length(), target);
  }
  /// Targets that came from other workers.
  struct Received {
    ScoringTargets targets;
    VarianceStatistics statistics() const { return VarianceStatistics(targets); }
  };
  Received received(std::span<const std::int16_t* const> rows) const {
    Received samples{{.dimensions = targets_->dimensions, .values = {}}};
    for (const std::int16_t* const row : rows) {
      samples.targets.values.insert(samples.targets.values.end(), row, row + target_length());
    }
    return samples;
  }

 private:
  const ScoringTargets* targets_;
};

template <int kLanes>
void VarianceStatistics<kLanes>::Node::assign(const ScoringTargets& targets,
                                              std::span<const std::uint32_t> samples) {
  count_ = samples.size();
  samples_ = samples;
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
ThresholdSplit VarianceStatistics<kLanes>::Node::best_split(std::span<const std::int16_t> values,
                                                            std::size_t /*candidate*/,
                                                            const TreeOptions& options,
                                                            Scratch& scratch) const {
  const ValueBins parts(values, bins_for(options, count_));
  if (parts.count() < 2) return {};
  scratch.bins.resize(count_);
  parts.assign(values, scratch.bins.data());
  const BinSplit split = best_bin(parts.count(), options.min_leaf_samples, scratch);
  return {static_cast<std::int16_t>(parts.first_value(split.bin)), split.gain};
}

template <int kLanes>
auto VarianceStatistics<kLanes>::Node::best_bin(int bin_count, int min_samples, Scratch& scratch) const
    -> BinSplit {
  std::fill_n(scratch.sums.begin(), bin_count, std::array<Int32x8, kRegisters>{});
  for (std::size_t i = 0; i < count_; ++i) {
    std::array<Int32x8, kRegisters>& sum = scratch.sums[scratch.bins[i]];
    for (std::size_t r = 0; r < kRegisters; ++r) sum[r] += rows_[i][r];
  }
  BinSplit best;
  const auto most_left = static_cast<std::int32_t>(count_) - min_samples;
  std::array<Int32x8, kRegisters> left{};
  for (int bin = 0; bin + 1 < bin_count; ++bin) {
    const std::array<Int32x8, kRegisters>& sum = scratch.sums[static_cast<std::size_t>(bin)];
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
