// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/shard_sum.h"

#include <torch/utils.h>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/worker_group_testing.h"

namespace knuckle {
namespace {

using testing::ThreadWorkers;

constexpr int kShards = 5;

/// Numbers of very different sizes, whose sum hangs on its order.
std::vector<torch::Tensor> values_of(int shard) {
  Random random(7, static_cast<std::uint64_t>(shard));
  std::vector<torch::Tensor> tensors{torch::zeros({3, 4}), torch::zeros({7}), torch::zeros({})};
  for (const torch::Tensor& tensor : tensors) {
    auto* const numbers = tensor.data_ptr<float>();
    for (int64_t i = 0; i < tensor.numel(); ++i) {
      numbers[i] = static_cast<float>(random.uniform(-1.0, 1.0) * std::pow(10.0, random.uniform(-4.0, 4.0)));
    }
  }
  return tensors;
}

std::vector<torch::Tensor> summed_in_order() {
  std::vector<torch::Tensor> sum = values_of(0);
  for (int shard = 1; shard < kShards; ++shard) {
    const std::vector<torch::Tensor> terms = values_of(shard);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i].add_(terms[i]);
  }
  return sum;
}

class ShardSumOf : public ::testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Workers, ShardSumOf, ::testing::Values(1, 2, 3, 4, 5));

TEST_P(ShardSumOf, WorkersHasTheBitsOfTheSumInOrder) {
  const std::vector<torch::Tensor> expected = summed_in_order();
  ThreadWorkers group(GetParam());
  group.run([&](WorkerGroup& workers) {
    const PartOfWork shards = part_of_worker(kShards, workers.rank(), workers.size());
    std::vector<std::vector<torch::Tensor>> own;
    std::vector<double> losses;
    for (auto shard = static_cast<int>(shards.begin); shard < shards.end; ++shard) {
      own.push_back(values_of(shard));
      losses.push_back(0.1 * shard);
    }
    own.front()[0] = own.front()[0].t().contiguous().t();  // another order in memory
    const std::vector<double> all = ShardSum(workers, kShards).sum(own, losses);
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_TRUE(torch::equal(own.front()[i], expected[i])) << i;
    ASSERT_EQ(all.size(), static_cast<std::size_t>(kShards));
    for (int shard = 0; shard < kShards; ++shard)
      EXPECT_EQ(all[static_cast<std::size_t>(shard)], 0.1 * shard);
  });
}

TEST(WorkerGroup, SaysWhoIsDifferent) {
  ThreadWorkers group(3);
  group.run([](WorkerGroup& workers) {
    EXPECT_EQ(from_first(workers, fmt::format("of {}", workers.rank())), "of 0");
    EXPECT_EQ(gathered(workers, std::string(static_cast<std::size_t>(workers.rank()), 'x')),
              (std::vector<std::string>{"", "x", "xx"}));
    EXPECT_NO_THROW(require_same(workers, "other options", "a"));
    EXPECT_EQ(
        testing::error_of([&] { require_same(workers, "other options", workers.rank() == 2 ? "b" : "a"); }),
        "worker 2 of 3 has other options than worker 0");
  });
}

}  // namespace
}  // namespace knuckle
