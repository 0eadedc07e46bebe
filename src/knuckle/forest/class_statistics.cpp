// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/class_statistics.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "knuckle/forest/simd.h"

namespace knuckle {

namespace {

constexpr std::size_t kLanes = 16;
/// Thresholds compared in one pass: their counters stay in registers.
constexpr std::size_t kThresholdsPerPass = 8;

using Thresholds = std::array<std::int16_t, kThresholdsPerPass>;
using Counts = std::array<std::int32_t, kThresholdsPerPass>;

std::int32_t lane_sum(Int16x16 values) {
  std::array<Int16x8, 2> halves;
  std::memcpy(halves.data(), &values, sizeof(values));
  // Lanes count at most 65535 / 16, so two still fit 16 bits.
  const Int32x8 wide = __builtin_convertvector(halves[0] + halves[1], Int32x8);
  return ((wide[0] + wide[4]) + (wide[2] + wide[6])) + ((wide[1] + wide[5]) + (wide[3] + wide[7]));
}

/// How many of `count` values (a multiple of kLanes) lie below each threshold.
Counts count_below(const std::int16_t* values, std::size_t count, const Thresholds& thresholds) {
  std::array<Int16x16, kThresholdsPerPass> bounds;
  for (std::size_t t = 0; t < kThresholdsPerPass; ++t) bounds[t] = Int16x16{} + thresholds[t];
  std::array<Int16x16, kThresholdsPerPass> below{};
  for (std::size_t i = 0; i < count; i += kLanes) {
    Int16x16 lanes;
    std::memcpy(&lanes, values + i, sizeof(lanes));
    for (std::size_t t = 0; t < kThresholdsPerPass; ++t) below[t] += bounds[t] > lanes;  // -1 where true
  }
  Counts counts;
  for (std::size_t t = 0; t < kThresholdsPerPass; ++t) counts[t] = -lane_sum(below[t]);
  return counts;
}

}  // namespace

void ClassStatistics::Node::assign(std::span<const std::uint8_t> labels,
                                   std::span<const std::uint32_t> samples) {
  arranged_.clear();
  for (std::size_t label = 0; label < kClasses; ++label) {
    const std::size_t first = arranged_.size();
    for (const std::uint32_t sample : samples) {
      if (labels[sample] == label) arranged_.push_back(sample);
    }
    counts_[label] = arranged_.size() - first;
    if (counts_[label] == 0) return;  // pure: nothing else is asked for
    padded_[label] = (counts_[label] + kLanes - 1) / kLanes * kLanes;
    arranged_.resize(first + padded_[label], arranged_.back());
  }
  const double all = static_cast<double>(samples.size());
  weight_.assign(samples.size() + 1, 0.0);
  for (std::size_t left = 1; left < samples.size(); ++left) {
    weight_[left] = 2.0 / (all * static_cast<double>(left) * static_cast<double>(samples.size() - left));
  }
}

double ClassStatistics::Node::gain(std::int64_t left, std::int64_t left_ones) const {
  const auto ones = static_cast<std::int64_t>(counts_[1]);
  const auto all = static_cast<std::int64_t>(counts_[0] + counts_[1]);
  const auto difference = static_cast<double>(left_ones * all - left * ones);
  return difference * difference * weight_[static_cast<std::size_t>(left)];
}

ThresholdSplit ClassStatistics::Node::best_split(std::span<const std::int16_t> values, std::size_t candidate,
                                                 const TreeOptions& options, Scratch& /*scratch*/) const {
  const std::size_t all = counts_[0] + counts_[1];
  const std::size_t wanted = std::min(all, static_cast<std::size_t>(options.threshold_bins - 1));
  const std::size_t start = candidate % (all / wanted);  // candidates take turns at the samples
  const auto most_left = static_cast<std::int64_t>(all) - options.min_leaf_samples;
  const std::int16_t* const zeros = values.data();
  const std::int16_t* const ones = zeros + padded_[0];
  ThresholdSplit best;
  double best_gain = 0.0;
  for (std::size_t done = 0; done < wanted; done += kThresholdsPerPass) {
    Thresholds thresholds;
    for (std::size_t t = 0; t < kThresholdsPerPass; ++t) {  // a pass that is not full repeats the last
      thresholds[t] = value_of(values, start + std::min(done + t, wanted - 1) * all / wanted);
    }
    const Counts zeros_left = count_below(zeros, padded_[0], thresholds);
    const Counts ones_left = count_below(ones, padded_[1], thresholds);
    const auto extra_zeros = static_cast<std::int32_t>(padded_[0] - counts_[0]);
    const auto extra_ones = static_cast<std::int32_t>(padded_[1] - counts_[1]);
    for (std::size_t t = 0; t < kThresholdsPerPass; ++t) {
      const std::int64_t left_zeros = zeros_left[t] - (ones[-1] < thresholds[t] ? extra_zeros : 0);
      const std::int64_t left_ones = ones_left[t] - (ones[padded_[1] - 1] < thresholds[t] ? extra_ones : 0);
      const std::int64_t left = left_zeros + left_ones;
      if (left < options.min_leaf_samples || left > most_left) continue;
      const double gained = gain(left, left_ones);
      if (gained > best_gain) {
        best_gain = gained;
        best = {thresholds[t], static_cast<float>(gained)};
      }
    }
  }
  return best;
}

}  // namespace knuckle
