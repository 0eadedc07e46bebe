// SPDX-License-Identifier: Apache-2.0
// Where the samples of several workers stand in the one order that training works in.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/worker_group.h"

namespace knuckle {

/// What a sample's place in the canonical order hangs on: the hash of its contents, and among equal ones its
/// number in the source.
struct SampleKey {
  std::uint64_t hash = 0;
  std::int64_t number = 0;
};

/// The places of a worker's samples among those of all workers.
struct CanonicalPlaces {
  std::vector<std::int64_t> places;  ///< one per key, [0, total)
  std::int64_t total = 0;
};
/// Sorts the keys of all workers. Each worker sorts those whose hashes lie in its part of all hashes, so none
/// ever holds them all.
CanonicalPlaces canonical_places(WorkerGroup& workers, std::span<const SampleKey> own);

/// Where the workers' parts of `total` things begin, and the end: equal parts, by `part_of_worker`.
std::vector<std::int64_t> equal_cuts(std::int64_t total, int workers);

/// The worker whose part holds a place. `cuts`: where parts begin, and the end, ascending.
int worker_of_place(std::span<const std::int64_t> cuts, std::int64_t place);

/// A node's samples among the workers. They are a stretch of the tree's list of samples, which goes on from
/// worker to worker, so the parts of a node lie in the order of the workers.
struct NodeShare {
  std::int64_t first = 0;   ///< place of its first sample in the tree's list
  std::int64_t total = 0;   ///< samples of all workers
  std::int64_t before = 0;  ///< of them with workers before this one
  std::int32_t holder = kSeveral;

  static constexpr std::int32_t kSeveral = -1;  ///< of `holder`: more than one worker has samples of it
};

/// Adds up what all workers have of each node: `own` is one number per node, of the same nodes everywhere.
/// Sets all but `first`. Each worker sums a part of the nodes: 28 bytes per node and worker are exchanged.
std::vector<NodeShare> summed_shares(WorkerGroup& workers, std::span<const std::uint32_t> own);

/// The sum of a number over all workers, and over those before this one.
struct SumOfWorkers {
  std::int64_t total = 0;
  std::int64_t before = 0;
};
/// Adds up what each worker says.
SumOfWorkers sum_of_workers(WorkerGroup& workers, std::int64_t own);

/// Continues a hash through the words of all workers, one worker after another: what one process would get
/// from all words in this order. Called with the worker's own words.
std::uint64_t chained_hash(WorkerGroup& workers, std::span<const std::uint64_t> words);

}  // namespace knuckle
