// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/forest/tree_grower.h"
#include "knuckle/storage/model_file.h"

namespace knuckle {

/// A node of a tree in a flat array. A sample goes to node `next` where its feature is below the threshold,
/// else to the node after it.
template <class Feature>
struct TreeNode {
  std::int32_t next =
      -1;  ///< index of the left child; below 0: a leaf, and ~next is its row among the leaves
  Feature feature{};
  std::int16_t threshold = 0;
};

/// All trees of a forest one after another, each breadth-first; leaves are numbered in the order of their
/// nodes.
template <class Feature>
struct FlatTrees {
  using Node = TreeNode<Feature>;

  std::vector<std::uint32_t> roots;  ///< index of each tree's root; ascending, the first is 0
  std::vector<Node> nodes;

  std::size_t end_of(std::size_t tree) const {
    return tree + 1 < roots.size() ? roots[tree + 1] : nodes.size();
  }
};

/// Throws an Error that starts with `origin` where a node leads nowhere: to itself or back, out of its tree,
/// or to a leaf that is not there.
template <class Feature>
void check_trees(const FlatTrees<Feature>& trees, std::size_t leaf_count, const std::string& origin) {
  if (trees.roots.empty() || trees.roots[0] != 0) fail("{}: the forest has no first tree", origin);
  for (std::size_t tree = 0; tree < trees.roots.size(); ++tree) {
    const std::size_t begin = trees.roots[tree];
    const std::size_t end = trees.end_of(tree);
    if (begin >= end || end > trees.nodes.size()) fail("{}: tree {} has no nodes", origin, tree);
    for (std::size_t i = begin; i < end; ++i) {
      const std::int64_t next = trees.nodes[i].next;
      const bool is_sound =
          next < 0 ? ~next < static_cast<std::int64_t>(leaf_count)
                   : next > static_cast<std::int64_t>(i) && next + 1 < static_cast<std::int64_t>(end);
      if (!is_sound) fail("{}: node {} of tree {} leads nowhere", origin, i - begin, tree);
    }
  }
}

/// Adds a grown tree after those there are; its leaves are numbered from `first_leaf` on. Returns its leaves
/// as indices of the grown tree's nodes.
template <class Feature>
std::vector<std::size_t> append_nodes(FlatTrees<Feature>& trees, const GrownTree<Feature>& tree,
                                      std::size_t first_leaf) {
  const auto root = static_cast<std::int32_t>(trees.nodes.size());
  auto next_leaf = static_cast<std::int32_t>(first_leaf);
  trees.roots.push_back(static_cast<std::uint32_t>(root));
  std::vector<std::size_t> leaves;
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const GrownNode<Feature>& node = tree.nodes[i];
    if (node.left >= 0) {
      trees.nodes.push_back({root + node.left, node.feature, node.threshold});
    } else {
      trees.nodes.push_back({~next_leaf++, {}, 0});
      leaves.push_back(i);
    }
  }
  return leaves;
}

namespace detail {

template <class T>
void write_column(ModelWriter& file, std::string_view name, const std::vector<T>& values) {
  file.add(name, {values.size()}, values);
}

/// One value per element.
template <class T>
std::vector<T> read_column(const ModelFile& file, const std::string& name, std::size_t count) {
  if (file.shape(name) != std::vector<std::uint64_t>{count}) {
    fail("{}: {} is of another shape, expected one value for each of {} nodes", file.origin(), name, count);
  }
  ModelArray<T> array = file.read<T>(name);
  return std::move(array.values);
}

/// Writes the columns of features and thresholds of nodes or splits.
template <class Feature, class Element>
void write_splits(ModelWriter& file, const std::vector<Element>& elements) {
  const auto write = [&]<class T>(const std::string& name, T value) {
    std::vector<std::remove_cvref_t<decltype(value(elements[0]))>> column(elements.size());
    std::ranges::transform(elements, column.begin(), value);
    write_column(file, name, column);
  };
  Feature::for_each_column([&](const char* name, auto member) {
    write(name, [member](const Element& element) { return element.feature.*member; });
  });
  write("node_threshold", [](const Element& element) { return element.threshold; });
}

/// Fills them in.
template <class Feature, class Element>
void read_splits(const ModelFile& file, std::vector<Element>& elements) {
  Feature::for_each_column([&](const char* name, auto member) {
    using Value = std::remove_cvref_t<decltype(elements[0].feature.*member)>;
    const std::vector<Value> column = read_column<Value>(file, name, elements.size());
    for (std::size_t i = 0; i < elements.size(); ++i) elements[i].feature.*member = column[i];
  });
  const auto threshold = read_column<std::int16_t>(file, "node_threshold", elements.size());
  for (std::size_t i = 0; i < elements.size(); ++i) elements[i].threshold = threshold[i];
}

/// Numbers the children and leaves of all trees, breadth-first.
template <class Feature>
void link_nodes(FlatTrees<Feature>& trees, const std::vector<std::uint8_t>& is_leaf) {
  std::int32_t leaf = 0;
  std::int64_t child = 0;
  std::size_t tree = 0;
  for (std::size_t i = 0; i < trees.nodes.size(); ++i) {
    if (tree < trees.roots.size() && i == trees.roots[tree]) {
      child = static_cast<std::int64_t>(i) + 1;
      ++tree;
    }
    if (is_leaf[i] != 0) {
      trees.nodes[i].next = ~leaf++;
    } else {
      trees.nodes[i].next = static_cast<std::int32_t>(child);
      child += 2;
    }
  }
}

}  // namespace detail

/// Adds the trees to a file, or reads them back (unchecked: check_trees does that). Trees are breadth-first,
/// so the children of the k-th inner node of a tree are its nodes 2k + 1 and 2k + 2: a flag a node (leaf or
/// not) holds the whole structure, and compresses well.
template <class Feature>
void write_trees(ModelWriter& file, const FlatTrees<Feature>& trees) {
  detail::write_column(file, "tree_root", trees.roots);
  std::vector<std::uint8_t> is_leaf(trees.nodes.size());
  std::ranges::transform(trees.nodes, is_leaf.begin(),
                         [](const auto& node) { return node.next < 0 ? 1 : 0; });
  detail::write_column(file, "node_is_leaf", is_leaf);
  detail::write_splits<Feature>(file, trees.nodes);
}

/// Reads back what `write_trees` wrote.
template <class Feature>
FlatTrees<Feature> read_trees(const ModelFile& file) {
  FlatTrees<Feature> trees;
  trees.roots = file.read<std::uint32_t>("tree_root").values;
  const std::vector<std::uint8_t> is_leaf = file.read<std::uint8_t>("node_is_leaf").values;
  if (std::ssize(trees.roots) > limits::kTrees || std::ssize(is_leaf) > limits::kForestNodes) {
    fail("{}: a forest of {} trees and {} nodes, expected at most {} and {}", file.origin(),
         trees.roots.size(), is_leaf.size(), limits::kTrees, limits::kForestNodes);
  }
  trees.nodes.resize(is_leaf.size());
  detail::read_splits<Feature>(file, trees.nodes);
  detail::link_nodes(trees, is_leaf);
  return trees;
}

}  // namespace knuckle
