// SPDX-License-Identifier: Apache-2.0
// Which nodes of a shared tree are searched together, and by whom.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/forest/shared_places.h"
#include "knuckle/forest/split_options.h"

namespace knuckle {

/// Whether a node has enough samples for two leaves.
bool can_be_split(const NodeShare& node, const TreeOptions& options);
/// How many samples score a node's candidates.
std::int64_t scored_samples(const NodeShare& node, const TreeOptions& options);
/// What a node's search costs, in scored samples.
std::int64_t search_cost(const NodeShare& node, const TreeOptions& options);

/// Nodes [first, end) and who searches each.
struct NodeBatch {
  /// Nobody: the node is too small to be split.
  static constexpr int kNobody = -1;

  std::size_t first = 0;
  std::size_t end = 0;
  std::vector<int> searcher;

  std::size_t size() const { return end - first; }
  int searcher_of(std::size_t node) const { return searcher[node - first]; }
  /// Whether several workers share the node, which is searched.
  bool is_shared(std::size_t node, std::span<const NodeShare> shares) const {
    return shares[node].holder == NodeShare::kSeveral && searcher_of(node) != kNobody;
  }
};

/// The nodes from `first` on that are searched together: so many that each worker has something to do, and
/// that messages stay small. `entry_bytes`: what is sent of a scored sample. A node is searched by the worker
/// that has all of its samples; those that several share, by whoever has the least to do so far.
NodeBatch next_batch(std::span<const NodeShare> shares, std::size_t first, std::int64_t entry_bytes,
                     int workers, const TreeOptions& options);

}  // namespace knuckle
