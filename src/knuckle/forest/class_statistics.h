// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/forest/split_options.h"
#include "knuckle/forest/split_score.h"

namespace knuckle {

/// The reduction of Gini's impurity for two classes, 0 and 1; a model of the concept SplitStatistics.
///
/// A node of n samples, of which n1 are of class 1, has the impurity n * 2 (n1 / n) (1 - n1 / n). A split
/// that sends l of them left, l1 of class 1, and r right lowers it by exactly
///     gain = 2 (l1 n - l n1)^2 / (n l r),
/// and l, l1 are whole numbers: counting is exact, so the gain depends neither on order nor on threads.
///
/// The thresholds of a candidate are values of the node's own samples (all of them where there are at most
/// options.threshold_bins - 1, else so many, at even distances in the node's list): they lie where the values
/// lie, however far away a 'nothing there' is. Each is compared with all samples, 16 at a time. To that end
/// samples are handed over class by class, each class filled up to whole registers with its last sample.
class ClassStatistics {
 public:
  /// Nothing is needed but registers.
  struct Scratch {};

  /// The labels of the samples that have come to a node.
  class Node {
   public:
    void assign(std::span<const std::uint8_t> labels, std::span<const std::uint32_t> samples);
    std::span<const std::uint32_t> samples() const { return arranged_; }
    bool is_pure() const { return counts_[0] == 0 || counts_[1] == 0; }
    ThresholdSplit best_split(std::span<const std::int16_t> values, std::size_t candidate,
                              const TreeOptions& options, Scratch& scratch) const;

   private:
    static constexpr std::size_t kClasses = 2;

    std::int16_t value_of(std::span<const std::int16_t> values, std::size_t sample) const {
      return values[sample < counts_[0] ? sample : sample - counts_[0] + padded_[0]];
    }
    double gain(std::int64_t left, std::int64_t left_ones) const;

    std::array<std::size_t, kClasses> counts_{};  // samples of each class
    std::array<std::size_t, kClasses> padded_{};  // the same, filled up
    std::vector<std::uint32_t> arranged_;
    std::vector<double> weight_;  // 2 / (n l r) for each l
  };

  /// `labels` has the class of each sample of the set, 0 or 1.
  explicit ClassStatistics(std::span<const std::uint8_t> labels) : labels_(labels) {}
  void assign(std::span<const std::uint32_t> samples, Node& node) const { node.assign(labels_, samples); }

  /// The class of one sample, and statistics of samples that came from other workers.
  static std::size_t target_length() { return 1; }
  void read_target(std::uint32_t sample, std::int16_t* target) const { *target = labels_[sample]; }
  /// Classes that came from other workers.
  struct Received {
    std::vector<std::uint8_t> labels;
    ClassStatistics statistics() const { return ClassStatistics(labels); }
  };
  static Received received(std::span<const std::int16_t* const> rows) {
    Received samples;
    for (const std::int16_t* const row : rows) samples.labels.push_back(*row != 0 ? 1 : 0);
    return samples;
  }

 private:
  std::span<const std::uint8_t> labels_;
};

}  // namespace knuckle
