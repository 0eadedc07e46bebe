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

/// A node that is still to be searched: where the list has its samples, and what the search costs.
struct OpenNode {
  std::int64_t first = 0;
  std::int64_t cost = 0;
};

/// Where the list of a tree's samples is cut into the workers' parts. Parts are equal, but that no small node
/// is cut: the cut then lies at the nearer end of the node. Once no node is cut, cuts go where the work is:
/// leaves, of which one part may have more, need none.
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
  /// Whether no node is cut any more.
  bool part_no_node() const { return std::ranges::all_of(cuts_, &Cut::is_final); }

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

  /// Moves cuts that part no node to where all workers have equal costs, if one has an eighth too much: each
  /// by at most an eighth of a part, so that no worker holds more than a quarter more than its share.
  /// `open`: in the order of the list.
  void balance(std::span<const OpenNode> open) {
    if (open.empty() || !part_no_node()) return;
    std::vector<std::int64_t> before{0};  // costs of the nodes before each
    for (const OpenNode& node : open) before.push_back(before.back() + node.cost);
    const std::int64_t largest = largest_cost(open, before);
    const std::int64_t workers = std::ssize(cuts_);
    if (8 * workers * largest <= 9 * before.back()) return;
    const std::vector<std::int64_t> places = places_;
    for (std::int64_t k = 1; k < workers; ++k) {
      const std::int64_t cost = before.back() / workers * k;
      places_[static_cast<std::size_t>(k)] = place_for(cost, static_cast<std::size_t>(k), open, before);
    }
    if (largest_cost(open, before) >= largest) places_ = places;
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

  /// The first place of the open node before which all others cost most nearly so much, of those that are
  /// near enough to cut k; where none is, where the cut lies.
  std::int64_t place_for(std::int64_t cost, std::size_t k, std::span<const OpenNode> open,
                         std::span<const std::int64_t> before) const {
    const std::int64_t farthest = places_.back() / (8 * std::ssize(cuts_));
    const auto begin = std::ranges::lower_bound(open, cuts_[k].wanted - farthest, {}, &OpenNode::first);
    const auto end = std::ranges::upper_bound(open, cuts_[k].wanted + farthest, {}, &OpenNode::first);
    if (begin == end) return places_[k];
    const auto cost_before = [&](const OpenNode& node) {
      return before[static_cast<std::size_t>(&node - open.data())];
    };
    auto best = std::ranges::lower_bound(begin, end, cost, {}, cost_before);
    if (best == end || (best != begin && cost - cost_before(best[-1]) <= cost_before(*best) - cost)) --best;
    return best->first;
  }

  /// What the nodes of the worker that has most to do cost.
  std::int64_t largest_cost(std::span<const OpenNode> open, std::span<const std::int64_t> before) const {
    std::int64_t largest = 0;
    std::int64_t last = 0;
    for (const std::int64_t place : std::span(places_).subspan(1)) {
      const auto node = std::ranges::lower_bound(open, place, {}, &OpenNode::first) - open.begin();
      const std::int64_t cost = before[static_cast<std::size_t>(node)];
      largest = std::max(largest, cost - last);
      last = cost;
    }
    return largest;
  }

  std::vector<std::int64_t> places_;
  std::vector<Cut> cuts_;
  std::int64_t smallest_shared_ = 0;
};

}  // namespace knuckle
