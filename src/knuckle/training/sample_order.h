// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "knuckle/training/sample_views.h"

namespace knuckle {

/// The order in which the samples of a group are dealt: each once before any again, in another order in each
/// such epoch. A function of group and seed alone; what is dealt as the n-th is known without those before.
///
/// Samples in memory are shuffled all together. A group in runs, which are read from a disk, is shuffled
/// twice: the runs of an epoch come in random order, cut into windows of about as many each, and the samples
/// of a window are shuffled together. So of the whole set only a window's runs are read at a time. Where one
/// window holds all runs, the order is that of samples in memory.
class SampleOrder {
 public:
  /// Throws an Error where there is no sample.
  SampleOrder(SampleGroup group, std::uint64_t seed);
  /// The sample, in [0, size of the group), that is dealt as number `number` >= 0. Quick for numbers that
  /// rise: orders of an epoch and of a window are kept for the next call.
  std::int64_t at(std::int64_t number);

 private:
  void begin_epoch(std::int64_t epoch);
  void begin_window(std::size_t window);
  std::uint64_t seed_of_window(std::size_t window) const;

  SampleGroup group_;
  std::uint64_t seed_;
  std::vector<std::int64_t> first_of_run_;
  std::size_t windows_;

  std::int64_t epoch_ = -1;
  std::vector<std::int64_t> runs_;             ///< of the epoch, in their order
  std::vector<std::int64_t> first_of_window_;  ///< places in the epoch; then its end
  std::size_t window_ = 0;
  std::vector<std::int64_t> order_;  ///< of the window
};

}  // namespace knuckle
