// SPDX-License-Identifier: Apache-2.0
// The arrays of a forest in HDF5. Trees are breadth-first, so the children of the k-th inner node of a tree
// are its nodes 2k + 1 and 2k + 2: a flag a node (leaf or not) holds the whole structure, and compresses
// well.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/forest/regression_forest.h"

namespace knuckle {

namespace {

using Node = RegressionForest::Node;

constexpr int kDeflateLevel = 9;
constexpr std::uint64_t kNodesAChunk = 1 << 16;
constexpr std::uint64_t kLeavesAChunk = 1 << 10;

template <class T>
void write_column(Hdf5File& file, const std::string& name, const std::vector<T>& values,
                  std::uint64_t columns, std::uint64_t rows_a_chunk) {
  std::vector<std::uint64_t> shape{values.size() / columns};
  if (columns > 1) shape.push_back(columns);
  file.write(name, shape, values.data(), {std::min(rows_a_chunk, shape[0]), kDeflateLevel});
}

template <class T, class Value>
std::vector<T> column_of(const std::vector<Node>& nodes, Value value) {
  std::vector<T> column(nodes.size());
  std::ranges::transform(nodes, column.begin(), value);
  return column;
}

/// One value a node.
template <class T>
std::vector<T> read_column(const Hdf5File& file, const std::string& name, std::size_t count) {
  Hdf5Array<T> array = file.read<T>(name);
  if (array.shape.size() != 1 || array.values.size() != count) {
    fail("{}: {} has {} values, expected one for each of {} nodes", file.path().string(), name,
         array.values.size(), count);
  }
  return std::move(array.values);
}

/// Numbers the children and leaves of all trees, breadth-first.
void link_nodes(std::vector<Node>& nodes, const std::vector<std::uint32_t>& roots,
                const std::vector<std::uint8_t>& is_leaf) {
  std::int32_t leaf = 0;
  std::int64_t child = 0;
  std::size_t tree = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (tree < roots.size() && i == roots[tree]) {
      child = static_cast<std::int64_t>(i) + 1;
      ++tree;
    }
    if (is_leaf[i] != 0) {
      nodes[i].next = ~leaf++;
    } else {
      nodes[i].next = static_cast<std::int32_t>(child);
      child += 2;
    }
  }
}

template <class Code>
LeafTable::Codes read_codes(const Hdf5File& file, std::size_t columns) {
  Hdf5Array<Code> array = file.read<Code>("leaf_value");
  if (array.values.size() % columns != 0 || (array.shape.size() == 2 && array.shape[1] != columns)) {
    fail("{}: leaf_value has no rows of {} values", file.path().string(), columns);
  }
  return std::move(array.values);
}

LeafTable read_leaves(const Hdf5File& file) {
  const std::vector<float> offset = file.read<float>("leaf_offset").values;
  const std::vector<float> step = file.read<float>("leaf_step").values;
  const std::string origin = file.path().string();
  if (offset.empty()) fail("{}: leaf_offset is empty, expected a value a target", origin);
  const auto bits = static_cast<int>(file.number_attribute("leaf_bits"));
  switch (bits) {
    case 8:
      return {offset, step, read_codes<std::uint8_t>(file, offset.size()), origin};
    case 16:
      return {offset, step, read_codes<std::uint16_t>(file, offset.size()), origin};
    case 32:
      return {offset, step, read_codes<float>(file, offset.size()), origin};
    default:
      fail("{}: leaf_bits is {}, expected 8, 16 or 32", origin, bits);
  }
}

}  // namespace

void write_forest(Hdf5File& file, const RegressionForest& forest) {
  const RegressionForest::Parts& parts = forest.parts();
  file.set_attribute("feature_count", parts.feature_count);
  file.set_attribute("feature_step", parts.quantizer.step);
  file.set_attribute("leaf_bits", parts.leaves.bits());
  file.write("tree_root", {parts.roots.size()}, parts.roots.data());
  const std::vector<Node>& nodes = parts.nodes;
  write_column(file, "node_is_leaf",
               column_of<std::uint8_t>(nodes, [](const Node& n) { return n.next < 0 ? 1 : 0; }), 1,
               kNodesAChunk);
  write_column(file, "node_first", column_of<std::uint16_t>(nodes, &Node::first), 1, kNodesAChunk);
  write_column(file, "node_second", column_of<std::uint16_t>(nodes, &Node::second), 1, kNodesAChunk);
  write_column(file, "node_threshold", column_of<std::int16_t>(nodes, &Node::threshold), 1, kNodesAChunk);
  const auto columns = static_cast<std::uint64_t>(forest.target_count());
  file.write("leaf_offset", {columns}, parts.leaves.offset().data());
  file.write("leaf_step", {columns}, parts.leaves.step().data());
  std::visit([&](const auto& codes) { write_column(file, "leaf_value", codes, columns, kLeavesAChunk); },
             parts.leaves.codes());
}

RegressionForest read_forest(const Hdf5File& file) {
  RegressionForest::Parts parts;
  parts.feature_count = static_cast<int>(file.number_attribute("feature_count"));
  parts.quantizer.step = static_cast<float>(file.number_attribute("feature_step"));
  parts.roots = file.read<std::uint32_t>("tree_root").values;
  const std::vector<std::uint8_t> is_leaf = file.read<std::uint8_t>("node_is_leaf").values;
  const auto first = read_column<std::uint16_t>(file, "node_first", is_leaf.size());
  const auto second = read_column<std::uint16_t>(file, "node_second", is_leaf.size());
  const auto threshold = read_column<std::int16_t>(file, "node_threshold", is_leaf.size());
  parts.nodes.resize(is_leaf.size());
  for (std::size_t i = 0; i < is_leaf.size(); ++i) parts.nodes[i] = {0, first[i], second[i], threshold[i]};
  link_nodes(parts.nodes, parts.roots, is_leaf);
  parts.leaves = read_leaves(file);
  return {std::move(parts), file.path().string()};
}

}  // namespace knuckle
