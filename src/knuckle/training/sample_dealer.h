// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace knuckle {

/// Deals the places of a training, numbered from 0, to groups in the proportion of their weights: among the
/// first p places a group has its share of p, to one place for each group before it. Where a place goes hangs
/// on the weights alone, and is known without going through those before.
class SampleDealer {
 public:
  /// One weight per group, each positive and finite; at least one. Throws an Error otherwise.
  explicit SampleDealer(std::span<const double> weights);

  /// To which group a place is dealt, and as its how many-th, counted from 0.
  struct Dealt {
    std::size_t group = 0;
    std::int64_t number = 0;
  };
  Dealt at(std::int64_t place) const;  ///< place >= 0
  /// A group's part of all places, in [0, 1].
  double share(std::size_t group) const { return shares_[group]; }

 private:
  /// Of each group its part of what the groups before leave, in 2^-32: whole numbers, so that counts are
  /// exact. The last takes all that is left.
  std::vector<std::uint64_t> parts_of_rest_;
  std::vector<double> shares_;
};

}  // namespace knuckle
