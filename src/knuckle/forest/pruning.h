// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "knuckle/forest/flat_trees.h"

namespace knuckle {

/// The leaves of all trees of a forest: one row of `dimensions` values per leaf.
struct LeafRows {
  std::size_t dimensions = 0;
  std::vector<float> values;

  std::size_t count() const { return dimensions == 0 ? 0 : values.size() / dimensions; }
};

/// What pruning leaves of a forest's nodes; `next` is that of TreeNode, one per node.
struct PrunedNodes {
  std::vector<std::uint8_t> is_kept;  ///< one per node
  std::vector<std::uint8_t> is_leaf;  ///< one per node; only those that are kept count
  LeafRows leaves;                    ///< one row per kept leaf, in the order of the nodes
};

/// Merges two leaves of one parent at a time until at most `most_leaves` are left (or one per tree), always
/// those whose merging moves the forest's answers least: by Ward's criterion, the sum of squares
///     w1 w2 / (w1 + w2) |m1 - m2|^2
/// with m the leaves' values times `scale` (one per dimension) and w the number of leaves that each was made
/// of: leaves of a grown forest hold about equally many samples. A merged leaf is the mean of its parts.
PrunedNodes pruned_nodes(std::span<const std::int32_t> next, std::span<const std::uint32_t> roots,
                         LeafRows leaves, std::span<const float> scale, std::size_t most_leaves);

/// Trees after pruning.
template <class Feature>
struct PrunedTrees {
  FlatTrees<Feature> trees;
  LeafRows leaves;
};

/// The same on the trees of a forest.
template <class Feature>
PrunedTrees<Feature> pruned_trees(const FlatTrees<Feature>& trees, LeafRows leaves,
                                  std::span<const float> scale, std::size_t most_leaves) {
  std::vector<std::int32_t> next;
  next.reserve(trees.nodes.size());
  for (const auto& node : trees.nodes) next.push_back(node.next);
  PrunedNodes pruned = pruned_nodes(next, trees.roots, std::move(leaves), scale, most_leaves);

  PrunedTrees<Feature> result;
  std::vector<std::uint8_t> is_leaf;
  std::size_t tree = 0;
  for (std::size_t i = 0; i < trees.nodes.size(); ++i) {
    if (tree < trees.roots.size() && i == trees.roots[tree]) {
      result.trees.roots.push_back(static_cast<std::uint32_t>(result.trees.nodes.size()));
      ++tree;
    }
    if (pruned.is_kept[i] == 0) continue;
    is_leaf.push_back(pruned.is_leaf[i]);
    result.trees.nodes.push_back(pruned.is_leaf[i] != 0 ? TreeNode<Feature>{} : trees.nodes[i]);
  }
  detail::link_nodes(result.trees, is_leaf);  // what is left of a breadth-first order is breadth-first
  result.leaves = std::move(pruned.leaves);
  return result;
}

}  // namespace knuckle
