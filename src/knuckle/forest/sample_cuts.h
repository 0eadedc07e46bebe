// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace knuckle {

/// A node that is still to be searched: where the list has its samples, and what the search costs.
struct OpenNode {
  std::int64_t first = 0;
  std::int64_t total = 0;
  std::int64_t cost = 0;
};

/// Where the list of a tree's samples is cut into the workers' parts: where all have equal costs, as far as
/// no worker holds more than a quarter more than its share. Samples of a level's upper nodes are drawn, so
/// that large nodes cost no more than smaller ones, and leaves cost nothing: equal parts of the list are
/// unequal work.
class SampleCuts {
 public:
  SampleCuts() = default;
  /// `begin`: where the workers' parts begin at first. `total`: samples of the tree.
  SampleCuts(std::span<const std::int64_t> begin, std::int64_t total);

  /// Where the parts begin, and the end.
  const std::vector<std::int64_t>& places() const { return places_; }

  /// Finds the cuts again after nodes were split. `open`: in the order of the list; where there is none, cuts
  /// stay. A cut lies between two nodes if no large node has to be cut for equal costs, or if that leaves
  /// the costs nearly equal.
  void follow(std::span<const OpenNode> open);

 private:
  struct Costs;
  struct Range;

  std::int64_t place_for(std::int64_t cost, const Range& range, const Costs& costs) const;

  std::vector<std::int64_t> places_;
  std::int64_t smallest_shared_ = 0;
};

}  // namespace knuckle
