// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/sample_cuts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"
#include "knuckle/forest/shared_places.h"

namespace knuckle {
namespace {

using Places = std::vector<std::int64_t>;

/// Of a list that is cut into equal parts.
SampleCuts equal_parts(std::int64_t total, int workers) {
  Places begin = equal_cuts(total, workers);
  begin.pop_back();
  return {begin, total};
}

Places cuts_of(std::int64_t total, int workers, const std::vector<OpenNode>& open) {
  SampleCuts cuts = equal_parts(total, workers);
  cuts.follow(open);
  return cuts.places();
}

TEST(SampleCuts, StayWhereNothingIsToBeSearched) {
  SampleCuts cuts(Places{0, 900, 1300}, 3000);
  cuts.follow({});
  EXPECT_EQ(cuts.places(), (Places{0, 900, 1300, 3000}));
}

TEST(SampleCuts, LieBetweenNodesWhereCostsAreEqual) {
  EXPECT_EQ(cuts_of(1000, 2, {{0, 100, 10}, {100, 350, 10}, {450, 350, 10}, {800, 200, 10}}),
            (Places{0, 450, 1000}));
  // What is not open costs nothing: a leaf from 100 to 400, another from 700 on.
  EXPECT_EQ(cuts_of(1000, 2, {{0, 100, 10}, {400, 100, 10}, {500, 100, 10}, {600, 100, 10}}),
            (Places{0, 500, 1000}));
  EXPECT_EQ(cuts_of(900, 3, {{0, 240, 10}, {240, 300, 10}, {540, 360, 10}}), (Places{0, 240, 540, 900}));
}

TEST(SampleCuts, PartALargeNodeWhereElseOneWorkerHasTooMuch) {
  // 5,000 samples of each node are searched. Between nodes one worker would have two of three.
  EXPECT_EQ(cuts_of(80000, 2, {{0, 30000, 5000}, {30000, 30000, 5000}, {60000, 20000, 5000}}),
            (Places{0, 45000, 80000}));
  // 38 and 42 are nearly equal.
  EXPECT_EQ(cuts_of(80000, 2, {{0, 38000, 38000}, {38000, 4000, 4000}, {42000, 38000, 38000}}),
            (Places{0, 38000, 80000}));
  // 10 and 14 are not, but the node in the middle is small.
  EXPECT_EQ(cuts_of(8000, 2, {{0, 3800, 1000}, {3800, 400, 400}, {4200, 3800, 1000}}),
            (Places{0, 3800, 8000}));
  // The same node is large where a part has fewer samples: more than an eighth of it.
  EXPECT_EQ(cuts_of(6000, 2, {{0, 2800, 1000}, {2800, 400, 400}, {3200, 2800, 1000}}),
            (Places{0, 3000, 6000}));
}

TEST(SampleCuts, LetNoWorkerHoldMoreThanAQuarterMoreThanItsShare) {
  EXPECT_EQ(cuts_of(1000, 2, {{0, 50, 50}, {50, 50, 50}}), (Places{0, 375, 1000}));
  EXPECT_EQ(cuts_of(1000, 2, {{900, 50, 50}, {950, 50, 50}}), (Places{0, 625, 1000}));
  EXPECT_EQ(cuts_of(1000, 4, {{0, 10, 10}, {10, 10, 10}, {20, 10, 10}, {30, 10, 10}}),
            (Places{0, 61, 374, 687, 1000}));
  EXPECT_EQ(cuts_of(3, 4, {{0, 3, 3}}).back(), 3) << "fewer samples than workers";
}

/// What nodes before a place cost, if the cost of each is spread evenly over its samples.
double cost_before(std::int64_t place, const std::vector<OpenNode>& open) {
  double cost = 0.0;
  for (const OpenNode& node : open) {
    const double part = static_cast<double>(place - node.first) / static_cast<double>(node.total);
    cost += static_cast<double>(node.cost) * std::clamp(part, 0.0, 1.0);
  }
  return cost;
}

/// Nodes of all sizes one after another, about a third of them leaves, most of those towards the end.
std::vector<OpenNode> random_nodes(std::int64_t total, Random& random) {
  std::vector<OpenNode> open;
  for (std::int64_t first = 0; first < total;) {
    const std::int64_t size =
        std::min<std::int64_t>(total - first, 10 + random.below(random.below(4) == 0 ? 1500 : 60));
    const bool is_leaf = random.below(static_cast<std::uint32_t>(3 * total / 2)) < first;
    if (!is_leaf)
      open.push_back({.first = first, .total = size, .cost = std::min<std::int64_t>(size, 300) + 27});
    first += size;
  }
  return open;
}

TEST(SampleCuts, AreTheBestOfAllPlaces) {
  Random random(5);
  constexpr std::int64_t kTotal = 6000;
  int parting = 0;
  int bounded = 0;
  for (int round = 0; round < 200; ++round) {
    const int workers = 2 + round % 4;
    const std::vector<OpenNode> open = random_nodes(kTotal, random);
    const Places places = cuts_of(kTotal, workers, open);
    ASSERT_TRUE(std::ranges::is_sorted(places));
    ASSERT_EQ(places.back(), kTotal);
    const double all = cost_before(kTotal, open);
    const std::int64_t most = (5 * kTotal + 4 * workers - 1) / (4 * workers);
    for (int k = 1; k < workers; ++k) {
      const auto index = static_cast<std::size_t>(k);
      const double wanted = all * k / workers;
      const std::int64_t first = std::max(places[index - 1], kTotal - (workers - k) * most);
      const std::int64_t last = std::min(kTotal, places[index - 1] + most);
      ASSERT_GE(places[index], first);
      ASSERT_LE(places[index], last);
      if (places[index] == first || places[index] == last) ++bounded;
      const auto error_at = [&](std::int64_t place) { return std::abs(cost_before(place, open) - wanted); };
      double best = std::numeric_limits<double>::max();
      double best_between = best;
      for (std::int64_t place = first; place <= last; ++place) best = std::min(best, error_at(place));
      for (const OpenNode& node : open) {
        if (node.first >= first && node.first <= last)
          best_between = std::min(best_between, error_at(node.first));
      }
      const auto parted = std::ranges::find_if(open, [&](const OpenNode& node) {
        return places[index] > node.first && places[index] < node.first + node.total;
      });
      const double error = error_at(places[index]);
      if (parted == open.end()) {
        EXPECT_LE(error, best_between + 1.0);
        continue;
      }
      ++parting;
      EXPECT_LE(error, best + 8.0) << "a sample costs up to 3.7, and costs are whole numbers";
      const bool has_between = best_between < std::numeric_limits<double>::max();
      if (has_between) {
        EXPECT_GT(parted->total, std::min<std::int64_t>(1024, kTotal / (8 * workers)));
        EXPECT_GT(best_between * 16 * workers, all - 16.0 * workers) << "nearly equal without";
      }
    }
  }
  EXPECT_GT(parting, 50);
  EXPECT_GT(bounded, 20);
}

}  // namespace
}  // namespace knuckle
