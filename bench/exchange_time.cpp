// SPDX-License-Identifier: Apache-2.0
// How long workers take to sum a gradient, by its size: knuckle_exchange_time WORKERS [SHARDS]. Started by
// srun it measures the network between machines.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <torch/utils.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/training/freed_memory.h"
#include "knuckle/training/shard_sum.h"
#include "knuckle/workers/work_together.h"

namespace knuckle {
namespace {

constexpr int kRounds = 15;

/// The median over some rounds [s].
double time_of(WorkerGroup& workers, int shards, std::int64_t numbers) {
  const PartOfWork part = part_of_worker(shards, workers.rank(), workers.size());
  const auto own = static_cast<std::size_t>(part.size());
  std::vector<std::vector<torch::Tensor>> gradients(own);
  for (std::vector<torch::Tensor>& gradient : gradients) gradient = {torch::ones({numbers})};
  const std::vector<double> losses(own);
  ShardSum sum(workers, shards);
  std::vector<double> seconds;
  for (int round = 0; round < kRounds; ++round) {
    const Stopwatch watch;
    sum.sum(gradients, losses);
    seconds.push_back(watch.seconds());
  }
  std::ranges::nth_element(seconds, seconds.begin() + kRounds / 2);
  return seconds[kRounds / 2];
}

void measure(WorkerGroup& workers, int shards) {
  for (const std::int64_t numbers : {250, 2500, 25000, 250000, 558750, 2500000, 25000000}) {
    const double seconds = time_of(workers, shards, numbers);
    if (workers.rank() > 0) continue;
    fmt::print("{:9.3f} MB: {:9.3f} ms\n", 4e-6 * static_cast<double>(numbers), 1e3 * seconds);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace knuckle

int main(int count, char** arguments) {
  try {
    const std::vector<std::string> words(arguments, arguments + count);
    if (count < 2 || count > 3) knuckle::fail("usage: knuckle_exchange_time WORKERS [SHARDS]");
    const auto workers = static_cast<int>(knuckle::parse_integer(words[1], "WORKERS"));
    const int shards = count == 3 ? static_cast<int>(knuckle::parse_integer(words[2], "SHARDS")) : workers;
    if (workers < 2 || shards < workers) knuckle::fail("expected at least 2 workers, and as many shards");
    knuckle::work_together({.workers = workers, .command_line = words, .traits = {}, .advice = "start again"},
                           [&](knuckle::WorkerGroup* group) {
                             knuckle::keep_freed_memory();  // as in training
                             knuckle::measure(*group, shards);
                           });
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
