// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/node_batch.h"

#include <algorithm>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

constexpr std::int32_t kSeveral = NodeShare::kSeveral;

NodeShare node_of(std::int64_t total, std::int32_t holder) {
  return {.first = 0, .total = total, .before = 0, .holder = holder};
}

TreeOptions options_of(int samples_per_node) {
  TreeOptions options;
  options.samples_per_node = samples_per_node;
  options.min_leaf_samples = 5;
  return options;
}

TEST(NodeBatch, IsSearchedByHoldersAndByWhoHasTheLeastToDo) {
  const std::vector<NodeShare> shares{node_of(90, 1),        node_of(9, 0),        node_of(200, 0),
                                      node_of(40, kSeveral), node_of(9, kSeveral), node_of(60, kSeveral),
                                      node_of(10, kSeveral), node_of(700, 2)};
  const NodeBatch batch = next_batch(shares, 1, 2, 3, options_of(500));
  EXPECT_EQ(batch.first, 1u);
  EXPECT_EQ(batch.end, shares.size());
  // Costs 227 of worker 0 and 527 of worker 2 at first; worker 1 takes 67, 87 and 37.
  EXPECT_EQ(batch.searcher, (std::vector<int>{NodeBatch::kNobody, 0, 1, NodeBatch::kNobody, 1, 1, 2}));
  EXPECT_FALSE(batch.is_shared(2, shares));
  EXPECT_TRUE(batch.is_shared(3, shares));
  EXPECT_FALSE(batch.is_shared(4, shares)) << "nobody searches it";
}

TEST(NodeBatch, ASearchCostsSomethingWithFewSamplesToo) {
  // Six small nodes take longer than one of as many samples.
  std::vector<NodeShare> shares(6, node_of(10, 0));
  shares.push_back(node_of(60, 1));
  shares.push_back(node_of(50, kSeveral));
  EXPECT_EQ(next_batch(shares, 0, 2, 2, options_of(500)).searcher.back(), 1);
  EXPECT_EQ(search_cost(node_of(1000, 0), options_of(500)), search_cost(node_of(500, 0), options_of(500)));
}

TEST(NodeBatch, DealsTheCostliestFirst) {
  const std::vector<NodeShare> shares{node_of(50, kSeveral), node_of(60, kSeveral), node_of(70, kSeveral),
                                      node_of(300, kSeveral)};
  EXPECT_EQ(next_batch(shares, 0, 2, 2, options_of(500)).searcher, (std::vector<int>{1, 1, 1, 0}));
}

TEST(NodeBatch, FollowsOneAnotherAndHoldsAsManySharedNodesForEachWorker) {
  Random random(2);
  std::vector<NodeShare> shares;
  for (int i = 0; i < 500; ++i) {
    shares.push_back(node_of(1 + random.below(20000), random.below(3) == 0 ? 1 : kSeveral));
  }
  const TreeOptions options = options_of(5000);
  constexpr std::int64_t kEntryBytes = 500;
  constexpr int kWorkers = 3;
  // What is sent to each is at most 16 MB, and a node more for each that makes the number even.
  constexpr std::int64_t kMostSamples = ((std::int64_t{16} << 20) / kEntryBytes + 5000) * kWorkers;
  std::size_t next = 0;
  int batches = 0;
  while (next < shares.size()) {
    const NodeBatch batch = next_batch(shares, next, kEntryBytes, kWorkers, options);
    ASSERT_EQ(batch.first, next);
    ASSERT_GT(batch.end, next);
    std::int64_t shared = 0;
    std::int64_t shared_samples = 0;
    for (std::size_t node = batch.first; node < batch.end; ++node) {
      if (shares[node].holder != kSeveral) continue;
      ++shared;
      shared_samples += scored_samples(shares[node], options);
    }
    EXPECT_TRUE(shared % kWorkers == 0 || batch.end == shares.size());
    EXPECT_LE(shared_samples, kMostSamples);
    next = batch.end;
    ++batches;
  }
  EXPECT_GT(batches, 5);
}

}  // namespace
}  // namespace knuckle
