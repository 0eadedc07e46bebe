// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/random.h"
#include "knuckle/forest/split_options.h"
#include "knuckle/forest/split_search.h"

namespace knuckle {

/// A node of a grown tree and the samples that reach it: entries [begin, end) of GrownTree::samples.
template <class Feature>
struct GrownNode {
  Feature feature{};
  std::int16_t threshold = 0;
  std::int32_t left = -1;  ///< index of the left child, the right one follows; -1: a leaf
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

/// The structure of a tree: nodes breadth-first, node 0 is the root.
template <class Feature>
struct GrownTree {
  std::vector<GrownNode<Feature>> nodes;
  std::vector<std::uint32_t> samples;

  std::span<const std::uint32_t> samples_of(const GrownNode<Feature>& node) const {
    return std::span(samples).subspan(node.begin, node.end - node.begin);
  }
};

/// The splits of a tree's nodes, breadth-first, also of those that have none (gain 0). With the samples it
/// determines the tree: a stopped training goes on from the log alone.
template <class Feature>
using SplitLog = std::vector<NodeSplit<Feature>>;

/// Throws an Error where a split that comes from a checkpoint or another worker reads what samples have not.
template <class Features, class Feature>
void check_splits(const Features& features, std::span<const NodeSplit<Feature>> splits) {
  for (const NodeSplit<Feature>& split : splits) {
    if (split.gain > 0.0F && !features.can_read(split.feature))
      fail("forest training: a split reads what no sample has: the checkpoint or another worker is damaged");
  }
}

/// Throws an Error where such a split leaves no sample on one side.
inline void check_sides(std::int64_t left, std::int64_t right) {
  if (left > 0 && right > 0) return;
  fail("forest training: a split parts no samples: the checkpoint or another worker is damaged");
}

/// Calls `visit` for `count` of the places 0, ..., `all` - 1, drawn without replacement, in their order
/// (selection sampling, Knuth vol. 2, 3.4.2 S).
template <class Visit>
void for_each_drawn(std::int64_t all, std::int64_t count, Random& random, const Visit& visit) {
  std::int64_t drawn = 0;
  for (std::int64_t place = 0; place < all && drawn < count; ++place) {
    const auto left = static_cast<double>(all - place);
    if (left * random.uniform() >= static_cast<double>(count - drawn)) continue;
    visit(place);
    ++drawn;
  }
}

/// How many samples a tree sees of `all`.
inline std::int64_t bag_size(const TreeOptions& options, std::int64_t all) {
  const double share = options.bagging_fraction * static_cast<double>(all);
  return std::clamp<std::int64_t>(std::lround(share), 1, all);
}

/// Numbers of the streams a tree draws from: 0 for its bag, then one per node.
inline constexpr std::uint64_t kBagStream = 0;
/// The stream of a node.
inline Random stream_of_node(std::uint64_t seed, std::size_t node) {
  return Random(seed, kBagStream + 1 + node);
}

/// Searches `count` nodes on all threads: those with many samples one after another, with their candidates in
/// parallel, the others in parallel. `scored(i)` is how many samples score node i, `search(i, memory, loop)`
/// does it, and `large` is the memory for large ones. The result does not depend on the number of threads.
template <class Search, class Scored, class Work>
void search_nodes(std::size_t count, const Scored& scored, Search& large, const Work& search) {
  /// Nodes with more scored samples than this share their candidates among the threads.
  constexpr std::size_t kLargeNode = 1024;
  /// Small nodes are handed to a thread in groups of about this many samples.
  constexpr std::size_t kSamplesPerGroup = 1024;
  std::vector<std::pair<std::size_t, std::size_t>> groups;  // ranges of small nodes
  std::size_t group_samples = kSamplesPerGroup;
  for (std::size_t node = 0; node < count; ++node) {
    const std::size_t samples = scored(node);
    if (samples > kLargeNode) {
      search(node, large, parallel_for);
      group_samples = kSamplesPerGroup;  // a group holds neighbours only
      continue;
    }
    if (group_samples >= kSamplesPerGroup) {
      groups.emplace_back(node, node);
      group_samples = 0;
    }
    groups.back().second = node + 1;
    group_samples += samples;
  }
  parallel_for(std::ssize(groups), [&](std::int64_t group) {
    Search memory;
    const auto [first, end] = groups[static_cast<std::size_t>(group)];
    for (std::size_t node = first; node < end; ++node) search(node, memory, serial_for);
  });
}

/// Moves samples so that those that go left by `split` come first, both sides in their order. Returns how
/// many go left.
template <class Features, class Node>
std::uint32_t partitioned(const Features& features, const Node& split, std::span<std::uint32_t> samples) {
  const auto right = std::stable_partition(samples.begin(), samples.end(), [&](std::uint32_t sample) {
    return features.value(sample, split.feature) < split.threshold;
  });
  return static_cast<std::uint32_t>(right - samples.begin());
}

/// Grows one tree, level by level, on all threads: nodes with many samples one after another with their
/// candidates in parallel, the others in parallel. Each node draws from a stream of its own, named by its
/// number, so the tree is the same for any number of threads.
template <SplitFeatures Features, SplitStatistics Statistics>
class TreeGrower {
 public:
  using Feature = typename Features::Feature;
  using Tree = GrownTree<Feature>;
  using Log = SplitLog<Feature>;

  TreeGrower(const Features& features, const Statistics& statistics, const TreeOptions& options)
      : features_(features), statistics_(statistics), options_(options) {}

  /// `samples` in the order to work in; `seed` is the tree's own. `log` has the splits of the first nodes,
  /// found by a run that was stopped, or none: they are not searched for again. Each split found is added to
  /// it, and `nodes_done` is called every few seconds of work, with the log. Advances `progress` by
  /// kStepsPerLevel a level.
  Tree grow(std::span<const std::uint32_t> samples, std::uint64_t seed, Progress& progress, Log& log,
            const std::function<void(const Log&)>& nodes_done);

  /// Steps of progress a level: a node advances it by its part of the samples.
  static constexpr std::int64_t kStepsPerLevel = 1000;

 private:
  using Split = NodeSplit<Feature>;
  using Search = SplitSearch<Features, Statistics>;

  /// Nodes are split in batches of about this many scored samples: what a stop loses at most.
  static constexpr std::size_t kSamplesPerBatch = 1 << 18;

  std::vector<std::uint32_t> bag(std::span<const std::uint32_t> samples, std::uint64_t seed) const;
  std::size_t batch_end(const Tree& tree, std::size_t first_node) const;
  void split_batch(const Tree& tree, std::size_t end_node, std::uint64_t seed, Log& log);
  Split split_node(const Tree& tree, std::size_t node, std::uint64_t seed, Search& search,
                   typename Search::Loop loop) const;
  void add_children(Tree& tree, std::size_t first_node, std::span<const Split> splits) const;
  std::uint32_t partition(Tree& tree, std::size_t node) const;
  std::size_t scored_samples(const Tree& tree, std::size_t node) const;

  const Features& features_;
  const Statistics& statistics_;
  TreeOptions options_;
  Search large_search_;
};

/// `count` of `samples`, drawn without replacement, in their order.
inline std::vector<std::uint32_t> random_subset(std::span<const std::uint32_t> samples, std::size_t count,
                                                Random& random) {
  std::vector<std::uint32_t> subset;
  subset.reserve(count);
  for_each_drawn(std::ssize(samples), static_cast<std::int64_t>(count), random,
                 [&](std::int64_t place) { subset.push_back(samples[static_cast<std::size_t>(place)]); });
  return subset;
}

template <SplitFeatures Features, SplitStatistics Statistics>
auto TreeGrower<Features, Statistics>::grow(std::span<const std::uint32_t> samples, std::uint64_t seed,
                                            Progress& progress, Log& log,
                                            const std::function<void(const Log&)>& nodes_done) -> Tree {
  check_splits(features_, std::span<const Split>(log));
  Tree tree;
  tree.samples = bag(samples, seed);
  tree.nodes.push_back({.end = static_cast<std::uint32_t>(tree.samples.size())});
  std::size_t first_node = 0;
  for (int depth = 0; depth < options_.max_depth; ++depth) {
    const std::size_t level_end = tree.nodes.size();
    std::int64_t steps_left = kStepsPerLevel;
    while (log.size() < level_end) {
      const std::size_t first = log.size();
      split_batch(tree, batch_end(tree, first), seed, log);
      const double part = static_cast<double>(tree.nodes[log.size() - 1].end - tree.nodes[first].begin) /
                          static_cast<double>(tree.samples.size());
      const auto steps = std::min(steps_left, static_cast<std::int64_t>(kStepsPerLevel * part));
      progress.advance(steps);
      steps_left -= steps;
      nodes_done(log);
    }
    if (first_node < level_end) {
      add_children(tree, first_node, std::span(log).subspan(first_node, level_end - first_node));
    }
    first_node = level_end;
    progress.advance(steps_left);
  }
  return tree;
}

template <SplitFeatures Features, SplitStatistics Statistics>
std::vector<std::uint32_t> TreeGrower<Features, Statistics>::bag(std::span<const std::uint32_t> samples,
                                                                 std::uint64_t seed) const {
  const auto count = static_cast<std::size_t>(bag_size(options_, std::ssize(samples)));
  if (count >= samples.size()) return {samples.begin(), samples.end()};
  Random random(seed, kBagStream);
  return random_subset(samples, count, random);
}

template <SplitFeatures Features, SplitStatistics Statistics>
std::size_t TreeGrower<Features, Statistics>::scored_samples(const Tree& tree, std::size_t node) const {
  return std::min(tree.samples_of(tree.nodes[node]).size(),
                  static_cast<std::size_t>(options_.samples_per_node));
}

/// The end of the batch that starts with this node.
template <SplitFeatures Features, SplitStatistics Statistics>
std::size_t TreeGrower<Features, Statistics>::batch_end(const Tree& tree, std::size_t first_node) const {
  std::size_t samples = 0;
  std::size_t node = first_node;
  while (node < tree.nodes.size() && samples < kSamplesPerBatch) samples += scored_samples(tree, node++);
  return node;
}

/// Adds the splits of the nodes up to `end_node` to the log.
template <SplitFeatures Features, SplitStatistics Statistics>
void TreeGrower<Features, Statistics>::split_batch(const Tree& tree, std::size_t end_node, std::uint64_t seed,
                                                   Log& log) {
  const std::size_t first_node = log.size();
  std::vector<Split> splits(end_node - first_node);
  const auto scored = [&](std::size_t i) { return scored_samples(tree, first_node + i); };
  search_nodes(splits.size(), scored, large_search_,
               [&](std::size_t i, Search& search, typename Search::Loop loop) {
                 splits[i] = split_node(tree, first_node + i, seed, search, loop);
               });
  log.insert(log.end(), splits.begin(), splits.end());
}

template <SplitFeatures Features, SplitStatistics Statistics>
auto TreeGrower<Features, Statistics>::split_node(const Tree& tree, std::size_t node, std::uint64_t seed,
                                                  Search& search, typename Search::Loop loop) const -> Split {
  const std::span<const std::uint32_t> samples = tree.samples_of(tree.nodes[node]);
  if (samples.size() < 2 * static_cast<std::size_t>(options_.min_leaf_samples)) return {};
  Random random = stream_of_node(seed, node);
  const std::size_t scored = scored_samples(tree, node);
  if (scored == samples.size()) {
    return search.best_split(features_, statistics_, samples, options_, random, loop);
  }
  return search.best_split(features_, statistics_, random_subset(samples, scored, random), options_, random,
                           loop);
}

template <SplitFeatures Features, SplitStatistics Statistics>
void TreeGrower<Features, Statistics>::add_children(Tree& tree, std::size_t first_node,
                                                    std::span<const Split> splits) const {
  std::vector<std::uint32_t> middle(splits.size());
  parallel_for(std::ssize(splits), [&](std::int64_t i) {
    const Split& split = splits[static_cast<std::size_t>(i)];
    if (!(split.gain > 0.0F)) return;
    GrownNode<Feature>& node = tree.nodes[first_node + static_cast<std::size_t>(i)];
    node.feature = split.feature;
    node.threshold = split.threshold;
    middle[static_cast<std::size_t>(i)] = partition(tree, first_node + static_cast<std::size_t>(i));
  });
  for (std::size_t i = 0; i < splits.size(); ++i) {
    if (!(splits[i].gain > 0.0F)) continue;
    const auto left = static_cast<std::int32_t>(tree.nodes.size());
    GrownNode<Feature>& node = tree.nodes[first_node + i];
    check_sides(middle[i] - node.begin, node.end - middle[i]);
    node.left = left;
    const GrownNode<Feature> left_child{.begin = node.begin, .end = middle[i]};
    const GrownNode<Feature> right_child{.begin = middle[i], .end = node.end};
    tree.nodes.push_back(left_child);
    tree.nodes.push_back(right_child);
  }
}

/// Moves the node's samples so that those that go left come first, both sides in their order. Returns where
/// right starts.
template <SplitFeatures Features, SplitStatistics Statistics>
std::uint32_t TreeGrower<Features, Statistics>::partition(Tree& tree, std::size_t node) const {
  const GrownNode<Feature>& split = tree.nodes[node];
  const std::span<std::uint32_t> samples(tree.samples);
  return split.begin + partitioned(features_, split, samples.subspan(split.begin, split.end - split.begin));
}

}  // namespace knuckle
