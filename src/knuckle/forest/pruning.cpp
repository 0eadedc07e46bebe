// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pruning.h"

#include <algorithm>
#include <functional>
#include <queue>

namespace knuckle {
namespace {

constexpr std::int32_t kNone = -1;

/// The trees while their leaves are merged.
class LeafMerger {
 public:
  LeafMerger(std::span<const std::int32_t> next, std::span<const std::uint32_t> roots, LeafRows leaves,
             std::span<const float> scale)
      : next_(next.begin(), next.end()),
        parent_(next.size(), kNone),
        row_(next.size(), kNone),
        leaves_(std::move(leaves)),
        scale_(scale),
        weight_(leaves_.count(), 1.0),
        leaf_count_(leaves_.count()),
        tree_count_(roots.size()) {
    for (std::size_t i = 0; i < next_.size(); ++i) {
      if (next_[i] < 0) {
        row_[i] = ~next_[i];
      } else {
        parent_[left_of(i)] = parent_[left_of(i) + 1] = static_cast<std::int32_t>(i);
      }
    }
    for (std::size_t i = 0; i < next_.size(); ++i) offer(i);
  }

  void merge_until(std::size_t most_leaves) {
    while (leaf_count_ > std::max(most_leaves, tree_count_)) {
      const std::size_t node = cheapest_.top().second;
      cheapest_.pop();
      merge(node);
    }
  }

  PrunedNodes result() const {
    PrunedNodes pruned{std::vector<std::uint8_t>(next_.size()),
                       std::vector<std::uint8_t>(next_.size()),
                       {leaves_.dimensions, {}}};
    for (std::size_t i = 0; i < next_.size(); ++i) {
      const auto above = static_cast<std::size_t>(parent_[i]);
      pruned.is_kept[i] = parent_[i] == kNone || (pruned.is_kept[above] != 0 && row_[above] == kNone) ? 1 : 0;
      pruned.is_leaf[i] = row_[i] != kNone ? 1 : 0;
      if (pruned.is_kept[i] == 0 || pruned.is_leaf[i] == 0) continue;
      const float* const row = values_of(i);
      pruned.leaves.values.insert(pruned.leaves.values.end(), row, row + leaves_.dimensions);
    }
    return pruned;
  }

 private:
  using Candidate = std::pair<double, std::size_t>;  // cost of merging a node's children, the node

  std::size_t left_of(std::size_t node) const { return static_cast<std::size_t>(next_[node]); }
  const float* values_of(std::size_t leaf) const {
    return leaves_.values.data() + static_cast<std::size_t>(row_[leaf]) * leaves_.dimensions;
  }
  double& weight_of(std::size_t leaf) { return weight_[static_cast<std::size_t>(row_[leaf])]; }

  /// Makes the node a candidate where both its children are leaves.
  void offer(std::size_t node) {
    if (row_[node] != kNone) return;
    const std::size_t left = left_of(node);
    if (row_[left] == kNone || row_[left + 1] == kNone) return;
    const float* const a = values_of(left);
    const float* const b = values_of(left + 1);
    double squares = 0.0;
    for (std::size_t d = 0; d < leaves_.dimensions; ++d) {
      const double difference = double{scale_[d]} * (double{a[d]} - double{b[d]});
      squares += difference * difference;
    }
    const double w1 = weight_of(left);
    const double w2 = weight_of(left + 1);
    cheapest_.emplace(w1 * w2 / (w1 + w2) * squares, node);
  }

  void merge(std::size_t node) {
    const std::size_t left = left_of(node);
    const double w1 = weight_of(left);
    const double w2 = weight_of(left + 1);
    float* const mean = leaves_.values.data() + static_cast<std::size_t>(row_[left]) * leaves_.dimensions;
    const float* const other = values_of(left + 1);
    for (std::size_t d = 0; d < leaves_.dimensions; ++d) {
      mean[d] = static_cast<float>((w1 * double{mean[d]} + w2 * double{other[d]}) / (w1 + w2));
    }
    row_[node] = row_[left];
    weight_of(node) = w1 + w2;
    --leaf_count_;
    if (parent_[node] != kNone) offer(static_cast<std::size_t>(parent_[node]));
  }

  std::vector<std::int32_t> next_;
  std::vector<std::int32_t> parent_;
  std::vector<std::int32_t> row_;  // of a leaf, also of a merged one; kNone for inner nodes
  LeafRows leaves_;
  std::span<const float> scale_;
  std::vector<double> weight_;
  std::size_t leaf_count_;
  std::size_t tree_count_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> cheapest_;
};

}  // namespace

PrunedNodes pruned_nodes(std::span<const std::int32_t> next, std::span<const std::uint32_t> roots,
                         LeafRows leaves, std::span<const float> scale, std::size_t most_leaves) {
  LeafMerger merger(next, roots, std::move(leaves), scale);
  merger.merge_until(most_leaves);
  return merger.result();
}

}  // namespace knuckle
