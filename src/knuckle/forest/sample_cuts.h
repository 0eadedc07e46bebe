// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/worker_group.h"
#include "knuckle/forest/shared_places.h"

namespace knuckle {

/// Where the list of a tree's samples is cut into the workers' parts. Parts are equal, but that no small node
/// is cut: the cut then lies at the nearer end of the node, for good.
class SampleCuts {
 public:
  SampleCuts() = default;
  /// `begin`: where the workers' parts begin at first. `total`: samples of the tree.
  SampleCuts(std::span<const std::int64_t> begin, std::int64_t total)
      : places_(begin.begin(), begin.end()), cuts_(begin.size()) {
    places_.push_back(total);
    const int workers = static_cast<int>(begin.size());
    smallest_shared_ = std::min(kSmallNode, total / (kPartsPerWorker * workers));
    for (int k = 0; k < workers; ++k) {
      Cut& cut = cuts_[static_cast<std::size_t>(k)];
      cut.wanted = part_of_worker(total, k, workers).begin;
      cut.is_final = cut.wanted == 0;
    }
  }

  /// Where the parts begin, and the end.
  const std::vector<std::int64_t>& places() const { return places_; }
  /// Whether no cut will change any more.
  bool are_final() const { return std::ranges::all_of(cuts_, &Cut::is_final); }

  /// Finds the cuts again after nodes were split. `nodes` have a member `left`, the index of the left child,
  /// or -1.
  template <class Node>
  void follow(const std::vector<Node>& nodes, std::span<const NodeShare> shares) {
    for (std::size_t k = 0; k < cuts_.size(); ++k) {
      Cut& cut = cuts_[k];
      if (!cut.is_final) places_[k] = followed(cut, nodes, shares);
      if (cut.wanted == 0) places_[k] = 0;
    }
  }

 private:
  /// Nodes that are larger may be shared by several workers.
  static constexpr std::int64_t kSmallNode = 1024;
  /// So much smaller than a worker's part is a node at least that is not cut.
  static constexpr std::int64_t kPartsPerWorker = 8;

  struct Cut {
    std::int64_t wanted = 0;
    std::size_t node = 0;  // the one that is cut
    bool is_final = false;
  };

  template <class Node>
  std::int64_t followed(Cut& cut, const std::vector<Node>& nodes, std::span<const NodeShare> shares) const {
    while (nodes[cut.node].left >= 0) {
      const auto left = static_cast<std::size_t>(nodes[cut.node].left);
      cut.node = cut.wanted < shares[left + 1].first ? left : left + 1;
    }
    const std::int64_t begin = shares[cut.node].first;
    const std::int64_t end = begin + shares[cut.node].total;
    cut.is_final = cut.wanted == begin || end - begin <= smallest_shared_;
    if (!cut.is_final) return cut.wanted;
    return cut.wanted - begin <= end - cut.wanted ? begin : end;
  }

  std::vector<std::int64_t> places_;
  std::vector<Cut> cuts_;
  std::int64_t smallest_shared_ = 0;
};

}  // namespace knuckle
