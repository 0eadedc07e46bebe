// SPDX-License-Identifier: Apache-2.0
// Growing a tree whose samples are spread over several workers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/worker_messages.h"
#include "knuckle/forest/node_batch.h"
#include "knuckle/forest/received_features.h"
#include "knuckle/forest/sample_cuts.h"
#include "knuckle/forest/shared_places.h"
#include "knuckle/forest/tree_grower.h"

namespace knuckle {

/// A worker's samples, in the canonical order of all.
struct OwnSamples {
  std::vector<std::uint32_t> samples;
  SumOfWorkers count;  ///< of samples: of all workers, and of those before this one
};

/// A worker's part of a tree: all nodes, with its own samples of each.
template <class Feature>
struct SharedTree {
  GrownTree<Feature> own;
  std::vector<NodeShare> shares;  ///< one per node
};

/// Moves samples so that each worker has those whose places lie in its part, and returns them in that order:
/// moved_to_places. Empty where samples stay with their workers.
using MoveSamples = std::function<std::vector<std::uint32_t>(std::span<const std::uint32_t> samples,
                                                             std::span<const std::int64_t> places,
                                                             std::span<const std::int64_t> cuts)>;

/// Grows the tree that TreeGrower would grow from the samples of all workers, level by level. A tree's list
/// of samples is cut into one part per worker.
///
/// A node whose samples lie with one worker is searched there. Of one that several share, the scored samples
/// (what candidates read of them, and their targets) are sent to one of the workers, which searches it: the
/// one that has the least to do. All get all splits, and part their own samples by them. Where
/// samples can be moved, they then move to where the list of the next level has them: as soon as a node is
/// small, one worker has all of it.
template <SharedFeatures Features, SharedStatistics Statistics>
class SharedTreeGrower {
 public:
  using Feature = typename Features::Feature;
  using Tree = SharedTree<Feature>;
  using Log = SplitLog<Feature>;

  SharedTreeGrower(WorkerGroup& workers, const Features& features, const Statistics& statistics,
                   const TreeOptions& options, MoveSamples move)
      : workers_(workers),
        features_(features),
        statistics_(statistics),
        options_(options),
        move_(std::move(move)) {}

  /// See TreeGrower. All workers have the same log; `nodes_done` is called by all.
  Tree grow(const OwnSamples& samples, std::uint64_t seed, Progress& progress, Log& log,
            const std::function<void(const Log&)>& nodes_done);

  static constexpr std::int64_t kStepsPerLevel = TreeGrower<Features, Statistics>::kStepsPerLevel;

 private:
  using Split = NodeSplit<Feature>;
  using Search = SplitSearch<Features, Statistics>;
  using Block = typename Features::Block;

  /// This worker's samples of those that score the candidates of a node, and the numbers that come after
  /// their drawing.
  struct Drawn {
    std::vector<std::uint32_t> samples;
    Random random{0};
  };

  /// A node that this worker searches, with what others have sent of its scored samples: the targets of each,
  /// then its features; empty where this worker has all of them itself.
  struct Job {
    std::size_t node = 0;
    std::vector<const std::int16_t*> entries;
  };

  void start(const OwnSamples& samples, std::uint64_t seed);
  std::vector<std::int64_t> begins_of_all(std::int64_t own, std::int64_t total);
  void split_batch(const NodeBatch& batch, std::uint64_t seed, Log& log);
  bool has_shared_nodes(const NodeBatch& batch) const;
  std::vector<Drawn> drawn_of_shared(const NodeBatch& batch, std::uint64_t seed) const;
  Drawn drawn_of(std::size_t node, std::uint64_t seed) const;
  std::vector<std::byte> sent_samples(const NodeBatch& batch, int worker, std::span<const Drawn> drawn) const;
  std::vector<Job> jobs_of(const NodeBatch& batch, const ReceivedMessages& received) const;
  Split searched(const Job& job, Drawn drawn, Search& search, typename Search::Loop loop) const;
  void share_splits(const NodeBatch& batch, const std::vector<Job>& jobs, std::vector<Split>& splits) const;
  void add_children(std::size_t first_node, std::span<const Split> splits);
  void move_samples(std::size_t level_begin);
  std::size_t scored(std::size_t node) const {
    return static_cast<std::size_t>(scored_samples(tree_.shares[node], options_));
  }
  /// Numbers that are sent of a sample.
  std::size_t entry_length(const Block& block) const {
    return statistics_.target_length() + features_.row_length(block);
  }
  std::size_t entry_length() const {
    Block block;
    Random random(0);
    features_.begin_node(random, options_, block);
    return entry_length(block);
  }

  WorkerGroup& workers_;
  const Features& features_;
  const Statistics& statistics_;
  TreeOptions options_;
  MoveSamples move_;
  Tree tree_;
  SampleCuts cuts_;
  Search large_search_;
};

template <SharedFeatures Features, SharedStatistics Statistics>
auto SharedTreeGrower<Features, Statistics>::grow(const OwnSamples& samples, std::uint64_t seed,
                                                  Progress& progress, Log& log,
                                                  const std::function<void(const Log&)>& nodes_done) -> Tree {
  check_splits(features_, std::span<const Split>(log));
  start(samples, seed);
  const std::int64_t bag = tree_.shares[0].total;
  const auto entry_bytes = static_cast<std::int64_t>(entry_length() * sizeof(std::int16_t));
  std::size_t first_node = 0;
  for (int depth = 0; depth < options_.max_depth; ++depth) {
    const std::size_t level_end = tree_.own.nodes.size();
    std::int64_t steps_left = kStepsPerLevel;
    while (log.size() < level_end) {
      const NodeBatch batch = next_batch(tree_.shares, log.size(), entry_bytes, workers_.size(), options_);
      split_batch(batch, seed, log);
      std::int64_t done = 0;
      for (std::size_t node = batch.first; node < batch.end; ++node) done += tree_.shares[node].total;
      const std::int64_t steps = std::min(steps_left, kStepsPerLevel * done / bag);
      progress.advance(steps);
      steps_left -= steps;
      nodes_done(log);
    }
    if (first_node < level_end) {
      add_children(first_node, std::span(log).subspan(first_node, level_end - first_node));
      if (move_) move_samples(level_end);
    }
    first_node = level_end;
    progress.advance(steps_left);
  }
  return std::move(tree_);
}

/// The root, and this worker's part of the samples that the tree sees.
template <SharedFeatures Features, SharedStatistics Statistics>
void SharedTreeGrower<Features, Statistics>::start(const OwnSamples& samples, std::uint64_t seed) {
  tree_ = {};
  const std::int64_t all = samples.count.total;
  const std::int64_t count = bag_size(options_, all);
  std::int64_t before = samples.count.before;
  if (count >= all) {
    tree_.own.samples = samples.samples;
  } else {
    Random random(seed, kBagStream);
    before = 0;
    for_each_drawn(all, count, random, [&](std::int64_t place) {
      const std::int64_t own = place - samples.count.before;
      if (own < 0) {
        ++before;
      } else if (own < std::ssize(samples.samples)) {
        tree_.own.samples.push_back(samples.samples[static_cast<std::size_t>(own)]);
      }
    });
  }
  tree_.own.nodes.push_back({.end = static_cast<std::uint32_t>(tree_.own.samples.size())});
  tree_.shares = summed_shares(workers_, std::vector<std::uint32_t>{tree_.own.nodes[0].end});
  if (tree_.shares[0].total != count)
    fail("forest training: workers have {} samples of a tree, expected {}", tree_.shares[0].total, count);
  cuts_ = SampleCuts(begins_of_all(before, count), count);
}

/// Where the workers' parts of a tree's samples begin.
template <SharedFeatures Features, SharedStatistics Statistics>
std::vector<std::int64_t> SharedTreeGrower<Features, Statistics>::begins_of_all(std::int64_t own,
                                                                                std::int64_t total) {
  std::vector<std::int64_t> begins = values_of_all(workers_, own);
  if (begins.front() != 0 || begins.back() > total || !std::ranges::is_sorted(begins))
    fail("forest training: the workers' parts of a tree's samples do not follow one another");
  return begins;
}

/// Adds the splits of a batch to the log.
template <SharedFeatures Features, SharedStatistics Statistics>
void SharedTreeGrower<Features, Statistics>::split_batch(const NodeBatch& batch, std::uint64_t seed,
                                                         Log& log) {
  std::vector<Drawn> drawn = drawn_of_shared(batch, seed);
  ReceivedMessages received;
  if (has_shared_nodes(batch)) {
    OwnMessages sent;
    for (int worker = 0; worker < workers_.size(); ++worker) {
      sent.push_back(sent_samples(batch, worker, drawn));
    }
    received = exchanged(workers_, std::move(sent));
  }
  const std::vector<Job> jobs = jobs_of(batch, received);
  std::vector<Split> splits(batch.size());
  search_nodes(
      jobs.size(), [&](std::size_t i) { return scored(jobs[i].node); }, large_search_,
      [&](std::size_t i, Search& search, typename Search::Loop loop) {
        const Job& job = jobs[i];
        const std::size_t place = job.node - batch.first;
        splits[place] = searched(
            job, job.entries.empty() ? drawn_of(job.node, seed) : std::move(drawn[place]), search, loop);
      });
  share_splits(batch, jobs, splits);
  log.insert(log.end(), splits.begin(), splits.end());
}

/// Whether samples of other workers are needed.
template <SharedFeatures Features, SharedStatistics Statistics>
bool SharedTreeGrower<Features, Statistics>::has_shared_nodes(const NodeBatch& batch) const {
  for (std::size_t node = batch.first; node < batch.end; ++node) {
    if (batch.is_shared(node, tree_.shares)) return true;
  }
  return false;
}

template <SharedFeatures Features, SharedStatistics Statistics>
auto SharedTreeGrower<Features, Statistics>::drawn_of(std::size_t node, std::uint64_t seed) const -> Drawn {
  const NodeShare& share = tree_.shares[node];
  const std::span<const std::uint32_t> own = tree_.own.samples_of(tree_.own.nodes[node]);
  const auto count = static_cast<std::int64_t>(scored(node));
  Drawn drawn{.samples = {}, .random = stream_of_node(seed, node)};
  if (count == share.total) {
    drawn.samples.assign(own.begin(), own.end());
    return drawn;
  }
  for_each_drawn(share.total, count, drawn.random, [&](std::int64_t place) {
    if (place < share.before || place >= share.before + std::ssize(own)) return;
    drawn.samples.push_back(own[static_cast<std::size_t>(place - share.before)]);
  });
  return drawn;
}

/// One per node of the batch, empty for those that one worker has alone.
template <SharedFeatures Features, SharedStatistics Statistics>
auto SharedTreeGrower<Features, Statistics>::drawn_of_shared(const NodeBatch& batch, std::uint64_t seed) const
    -> std::vector<Drawn> {
  std::vector<Drawn> drawn(batch.size());
  parallel_for(std::ssize(drawn), [&](std::int64_t i) {
    const std::size_t node = batch.first + static_cast<std::size_t>(i);
    if (batch.is_shared(node, tree_.shares)) drawn[static_cast<std::size_t>(i)] = drawn_of(node, seed);
  });
  return drawn;
}

/// What a worker is sent of the nodes that it searches: how many samples this one has of each, then for each
/// sample its targets and what candidates read of it.
template <SharedFeatures Features, SharedStatistics Statistics>
std::vector<std::byte> SharedTreeGrower<Features, Statistics>::sent_samples(
    const NodeBatch& batch, int worker, std::span<const Drawn> drawn) const {
  std::vector<std::size_t> nodes;
  for (std::size_t node = batch.first; node < batch.end; ++node) {
    if (tree_.shares[node].holder == NodeShare::kSeveral && batch.searcher_of(node) == worker) {
      nodes.push_back(node);
    }
  }
  if (nodes.empty()) return {};
  const auto samples_of = [&](std::size_t i) -> const std::vector<std::uint32_t>& {
    return drawn[nodes[i] - batch.first].samples;
  };
  std::vector<Block> blocks(nodes.size());
  parallel_for(std::ssize(nodes), [&](std::int64_t i) {
    const auto place = static_cast<std::size_t>(i);
    Random random = drawn[nodes[place] - batch.first].random;
    if (!samples_of(place).empty()) features_.begin_node(random, options_, blocks[place]);
  });
  const std::size_t length = entry_length();
  std::vector<std::byte> message;
  std::vector<std::size_t> begin(nodes.size());
  std::size_t entries = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    append_value(message, static_cast<std::uint32_t>(samples_of(i).size()));
    begin[i] = entries;
    entries += samples_of(i).size();
  }
  const std::size_t header = message.size();
  message.resize(header + entries * length * sizeof(std::int16_t));
  // Vectors of bytes are aligned for any number, and the header's length is even.
  auto* const numbers = reinterpret_cast<std::int16_t*>(message.data() + header);
  constexpr std::size_t kEntriesPerTask = 256;
  std::vector<std::pair<std::size_t, std::size_t>> tasks;  // node, and the first of its samples
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t k = 0; k < samples_of(i).size(); k += kEntriesPerTask) tasks.emplace_back(i, k);
  }
  parallel_for(std::ssize(tasks), [&](std::int64_t task) {
    const auto [i, first] = tasks[static_cast<std::size_t>(task)];
    const std::size_t end = std::min(first + kEntriesPerTask, samples_of(i).size());
    for (std::size_t k = first; k < end; ++k) {
      std::int16_t* const entry = numbers + (begin[i] + k) * length;
      statistics_.read_target(samples_of(i)[k], entry);
      features_.read_row(samples_of(i)[k], blocks[i], entry + statistics_.target_length());
    }
  });
  return message;
}

/// The nodes that this worker searches, those that it has alone and those of which samples were sent.
template <SharedFeatures Features, SharedStatistics Statistics>
auto SharedTreeGrower<Features, Statistics>::jobs_of(const NodeBatch& batch,
                                                     const ReceivedMessages& received) const
    -> std::vector<Job> {
  std::vector<Job> jobs;
  std::vector<std::size_t> shared;  // of the jobs
  for (std::size_t node = batch.first; node < batch.end; ++node) {
    if (batch.searcher_of(node) != workers_.rank()) continue;
    if (tree_.shares[node].holder == NodeShare::kSeveral) shared.push_back(jobs.size());
    jobs.push_back({node, {}});
  }
  const std::size_t length = entry_length();
  for (const std::span<const std::byte> message : received.parts) {  // in the order of the workers
    MessageReader reader(message);
    std::vector<std::uint32_t> counts(shared.size());
    reader.read(std::span(counts));
    for (std::size_t i = 0; i < shared.size(); ++i) {
      for (std::uint32_t k = 0; k < counts[i]; ++k) {
        const std::span<const std::byte> entry = reader.bytes(length * sizeof(std::int16_t));
        jobs[shared[i]].entries.push_back(reinterpret_cast<const std::int16_t*>(entry.data()));
      }
    }
    if (!reader.is_at_end()) fail("a worker's message of samples has {} bytes too many", reader.bytes_left());
  }
  for (const std::size_t job : shared) {
    if (jobs[job].entries.size() != scored(jobs[job].node)) {
      fail("workers have sent {} samples of node {}, expected {}", jobs[job].entries.size(), jobs[job].node,
           scored(jobs[job].node));
    }
  }
  return jobs;
}

template <SharedFeatures Features, SharedStatistics Statistics>
auto SharedTreeGrower<Features, Statistics>::searched(const Job& job, Drawn drawn, Search& search,
                                                      typename Search::Loop loop) const -> Split {
  if (job.entries.empty()) {
    return search.best_split(features_, statistics_, drawn.samples, options_, drawn.random, loop);
  }
  const auto received = statistics_.received(job.entries);
  std::vector<std::uint32_t> all(job.entries.size());
  std::iota(all.begin(), all.end(), 0U);
  return search.best_split(ReceivedFeatures(features_, job.entries, statistics_.target_length()),
                           received.statistics(), all, options_, drawn.random, loop);
}

/// Fills in what the others have found.
template <SharedFeatures Features, SharedStatistics Statistics>
void SharedTreeGrower<Features, Statistics>::share_splits(const NodeBatch& batch,
                                                          const std::vector<Job>& jobs,
                                                          std::vector<Split>& splits) const {
  std::vector<std::byte> own;
  for (const Job& job : jobs) append_value(own, splits[job.node - batch.first]);
  std::vector<std::int64_t> sizes(static_cast<std::size_t>(workers_.size()));
  for (const int searcher : batch.searcher) {
    if (searcher != NodeBatch::kNobody)
      sizes[static_cast<std::size_t>(searcher)] += std::int64_t{sizeof(Split)};
  }
  const ReceivedMessages received =
      exchanged(workers_, OwnMessages(static_cast<std::size_t>(workers_.size()), own), sizes);
  std::vector<MessageReader> readers(received.parts.begin(), received.parts.end());
  for (std::size_t node = batch.first; node < batch.end; ++node) {
    const int searcher = batch.searcher_of(node);
    if (searcher == NodeBatch::kNobody) continue;
    splits[node - batch.first] = readers[static_cast<std::size_t>(searcher)].template value<Split>();
  }
  check_splits(features_, std::span<const Split>(splits));
}

template <SharedFeatures Features, SharedStatistics Statistics>
void SharedTreeGrower<Features, Statistics>::add_children(std::size_t first_node,
                                                          std::span<const Split> splits) {
  std::vector<GrownNode<Feature>>& nodes = tree_.own.nodes;
  std::vector<std::uint32_t> left(splits.size());
  parallel_for(std::ssize(splits), [&](std::int64_t i) {
    const Split& split = splits[static_cast<std::size_t>(i)];
    if (!(split.gain > 0.0F)) return;
    GrownNode<Feature>& node = nodes[first_node + static_cast<std::size_t>(i)];
    node.feature = split.feature;
    node.threshold = split.threshold;
    left[static_cast<std::size_t>(i)] =
        partitioned(features_, node, std::span(tree_.own.samples).subspan(node.begin, node.end - node.begin));
  });
  std::vector<std::uint32_t> own;
  const std::size_t first_child = nodes.size();
  for (std::size_t i = 0; i < splits.size(); ++i) {
    if (!(splits[i].gain > 0.0F)) continue;
    const GrownNode<Feature> parent = nodes[first_node + i];
    nodes[first_node + i].left = static_cast<std::int32_t>(nodes.size());
    const std::uint32_t middle = parent.begin + left[i];
    nodes.push_back({.begin = parent.begin, .end = middle});
    nodes.push_back({.begin = middle, .end = parent.end});
    own.insert(own.end(), {left[i], parent.end - middle});
  }
  std::vector<NodeShare> shares = summed_shares(workers_, own);
  std::size_t child = 0;
  for (std::size_t i = 0; i < splits.size(); ++i) {
    if (!(splits[i].gain > 0.0F)) continue;
    check_sides(shares[child].total, shares[child + 1].total);
    if (shares[child].total + shares[child + 1].total != tree_.shares[first_node + i].total)
      fail("forest training: workers disagree on the samples of a node");
    shares[child].first = tree_.shares[first_node + i].first;
    shares[child + 1].first = shares[child].first + shares[child].total;
    child += 2;
  }
  tree_.shares.resize(first_child);
  tree_.shares.insert(tree_.shares.end(), shares.begin(), shares.end());
}

/// Moves the samples to where the list has them now, and cuts it where all workers have as much to do.
template <SharedFeatures Features, SharedStatistics Statistics>
void SharedTreeGrower<Features, Statistics>::move_samples(std::size_t level_begin) {
  std::vector<GrownNode<Feature>>& nodes = tree_.own.nodes;
  const std::vector<std::int64_t> cuts_before = cuts_.places();
  bool is_any_shared = false;  // if none is, all lie where the list has them
  std::vector<OpenNode> open;
  for (std::size_t node = level_begin; node < nodes.size(); ++node) {
    const NodeShare& share = tree_.shares[node];
    is_any_shared = is_any_shared || share.holder == NodeShare::kSeveral;
    if (!can_be_split(share, options_)) continue;
    open.push_back({.first = share.first, .total = share.total, .cost = search_cost(share, options_)});
  }
  cuts_.follow(open);
  if (!is_any_shared && cuts_.places() == cuts_before) return;
  std::vector<std::int64_t> places(tree_.own.samples.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].left >= 0) continue;
    const std::int64_t first = tree_.shares[i].first + tree_.shares[i].before;
    std::iota(places.begin() + nodes[i].begin, places.begin() + nodes[i].end, first);
  }
  tree_.own.samples = move_(tree_.own.samples, places, cuts_.places());
  const std::int64_t begin = cuts_.places()[static_cast<std::size_t>(workers_.rank())];
  const std::int64_t end = cuts_.places()[static_cast<std::size_t>(workers_.rank()) + 1];
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    NodeShare& share = tree_.shares[i];
    const auto within = [&](std::int64_t place) { return std::clamp(place, begin, end) - begin; };
    nodes[i].begin = static_cast<std::uint32_t>(within(share.first));
    nodes[i].end = static_cast<std::uint32_t>(within(share.first + share.total));
    share.before = std::clamp<std::int64_t>(begin - share.first, 0, share.total);
    const int first_holder = worker_of_place(cuts_.places(), share.first);
    const int last_holder = worker_of_place(cuts_.places(), share.first + share.total - 1);
    share.holder = first_holder == last_holder ? first_holder : NodeShare::kSeveral;
  }
}

}  // namespace knuckle
