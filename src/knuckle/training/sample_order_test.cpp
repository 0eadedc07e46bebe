// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/sample_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

/// 40 runs of 20 to 30 samples.
SampleGroup group_in_runs(std::int64_t window) {
  SampleGroup group{.window = window};
  for (int i = 0; i < 40; ++i) group.runs.push_back(20 + (7 * i) % 11);
  group.size = std::accumulate(group.runs.begin(), group.runs.end(), std::int64_t{0});
  return group;
}

std::vector<std::int64_t> order_of(SampleOrder order, std::int64_t first, std::int64_t count) {
  std::vector<std::int64_t> numbers;
  for (std::int64_t i = first; i < first + count; ++i) numbers.push_back(order.at(i));
  return numbers;
}

/// The run that each sample lies in.
std::vector<std::size_t> runs_of(const SampleGroup& group, const std::vector<std::int64_t>& numbers) {
  std::vector<std::size_t> run_of_sample;
  for (std::size_t run = 0; run < group.runs.size(); ++run)
    run_of_sample.insert(run_of_sample.end(), static_cast<std::size_t>(group.runs[run]), run);
  std::vector<std::size_t> runs;
  for (const std::int64_t number : numbers) runs.push_back(run_of_sample[static_cast<std::size_t>(number)]);
  return runs;
}

TEST(SampleOrder, DealsEachSampleOnceInEachEpoch) {
  for (const std::int64_t window : {0, 1, 100, 250, 100000}) {
    const SampleGroup group = group_in_runs(window);
    std::vector<std::int64_t> all(static_cast<std::size_t>(group.size));
    std::iota(all.begin(), all.end(), std::int64_t{0});
    std::vector<std::int64_t> before;
    for (int epoch = 0; epoch < 3; ++epoch) {
      std::vector<std::int64_t> order = order_of({group, 5}, epoch * group.size, group.size);
      EXPECT_NE(order, before);
      before = order;
      std::ranges::sort(order);
      EXPECT_EQ(order, all) << window;
    }
  }
}

TEST(SampleOrder, IsFixedByTheSeedAndKnownFromAnyStart) {
  const SampleGroup group = group_in_runs(100);
  const std::int64_t count = 2 * group.size + 50;
  const std::vector<std::int64_t> order = order_of({group, 5}, 0, count);
  EXPECT_NE(order_of({group, 6}, 0, count), order);
  SampleOrder jumping(group, 5);
  for (const std::int64_t number :
       {count - 1, std::int64_t{3}, group.size, group.size - 1, std::int64_t{500}, std::int64_t{4}})
    EXPECT_EQ(jumping.at(number), order[static_cast<std::size_t>(number)]) << number;
  for (std::int64_t first = 0; first < count; first += 313)
    EXPECT_EQ(SampleOrder(group, 5).at(first), order[static_cast<std::size_t>(first)]) << first;
}

TEST(SampleOrder, OfOneWindowIsThatOfSamplesInMemory) {
  SampleGroup in_memory = group_in_runs(0);
  in_memory.runs.clear();
  const SampleGroup group = group_in_runs(in_memory.size);
  const std::int64_t count = 2 * group.size;
  EXPECT_EQ(order_of({group, 5}, 0, count), order_of({in_memory, 5}, 0, count));
}

TEST(SampleOrder, TakesAWindowsSamplesFromItsRunsAlone) {
  SampleGroup group = group_in_runs(0);
  group.window = (group.size + 3) / 4;
  const std::vector<std::size_t> runs = runs_of(group, order_of({group, 5}, 0, group.size));
  std::vector<std::set<std::size_t>> windows(1);
  std::set<std::size_t> done;
  for (const std::size_t run : runs) {  // a run is never read again when ten others were begun since
    if (!windows.back().contains(run) && windows.back().size() == 10) {
      done.insert(windows.back().begin(), windows.back().end());
      windows.emplace_back();
    }
    EXPECT_FALSE(done.contains(run)) << run;
    windows.back().insert(run);
  }
  EXPECT_EQ(windows.size(), 4u);
}

/// The correlation of the runs that neighbours in an order come from.
double correlation_of_neighbours(const SampleGroup& group, std::uint64_t seed) {
  const std::vector<std::size_t> runs = runs_of(group, order_of({group, seed}, 0, group.size));
  const double mean = std::accumulate(runs.begin(), runs.end(), 0.0) / static_cast<double>(runs.size());
  double variance = 0.0;
  double covariance = 0.0;
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
    variance += (static_cast<double>(runs[i]) - mean) * (static_cast<double>(runs[i]) - mean);
    covariance += (static_cast<double>(runs[i]) - mean) * (static_cast<double>(runs[i + 1]) - mean);
  }
  return covariance / variance;
}

TEST(SampleOrder, MixesRunsTheBetterTheLargerTheWindow) {
  double all = 0.0;
  double half = 0.0;
  double few = 0.0;
  constexpr int kSeeds = 30;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    all += correlation_of_neighbours(group_in_runs(100000), seed) / kSeeds;
    half += correlation_of_neighbours(group_in_runs(500), seed) / kSeeds;
    few += correlation_of_neighbours(group_in_runs(1), seed) / kSeeds;
  }
  EXPECT_NEAR(all, 0.0, 0.03);  // 1000 samples, 30 times: deviation 0.006
  EXPECT_NEAR(half, 0.0, 0.1);
  EXPECT_GT(few, 0.9) << "one run after another";
}

TEST(SampleOrder, SkipsRunsWithoutSamplesAndRefusesNone) {
  SampleGroup group{.size = 4, .runs = {0, 3, 0, 0, 1}, .window = 1};
  std::vector<std::int64_t> order = order_of({group, 5}, 0, 4);
  std::ranges::sort(order);
  EXPECT_EQ(order, (std::vector<std::int64_t>{0, 1, 2, 3}));
  EXPECT_THAT(error_of([] { SampleOrder({.runs = {0, 0}}, 1); }), HasSubstr("no sample to train on"));
}

}  // namespace
}  // namespace knuckle
