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

/// Workers with a way of their own, which counts what it was given.
class WorkersWithAWay final : public WorkerGroup, public DeviceWorkers {
 public:
  explicit WorkersWithAWay(WorkerGroup& others) : others_(others) {}

  int rank() const override { return others_.rank(); }
  int size() const override { return others_.size(); }
  double seconds_in_exchange() const override { return 0.0; }
  std::int64_t bytes_sent() const override { return 0; }
  std::vector<std::byte> exchange(Messages /*sent*/, const std::vector<std::int64_t>& /*sizes*/) override {
    ADD_FAILURE() << "sent as bytes";
    return {};
  }
  std::unique_ptr<TensorExchange> exchange_on(const torch::Device& device) override {
    EXPECT_TRUE(device.is_cpu());
    return std::make_unique<Way>(*this);
  }
  std::int64_t numbers() const { return numbers_; }

 private:
  class Way final : public TensorExchange {
   public:
    explicit Way(WorkersWithAWay& workers) : workers_(workers) {}
    torch::Tensor exchange(const torch::Tensor& sent, std::vector<std::int64_t> sent_counts,
                           std::vector<std::int64_t> received_counts) override {
      workers_.numbers_ += sent.numel();
      for (std::int64_t& count : sent_counts) count *= 4;
      for (std::int64_t& count : received_counts) count *= 4;
      const auto* const first = static_cast<const std::byte*>(sent.data_ptr());
      std::vector<std::byte> received =
          workers_.others_.exchange({{first, first + sent.nbytes()}, sent_counts}, received_counts);
      return torch::from_blob(received.data(), {std::ssize(received) / 4}).clone();
    }

   private:
    WorkersWithAWay& workers_;
  };

  WorkerGroup& others_;
  std::int64_t numbers_ = 0;
};

TEST(ShardSum, TakesTheWayThatWorkersHaveForTheirDevice) {
  const std::vector<torch::Tensor> expected = summed_in_order();
  ThreadWorkers group(2);
  group.run([&](WorkerGroup& others) {
    WorkersWithAWay workers(others);
    ShardSum sum(workers, kShards);
    const PartOfWork shards = part_of_worker(kShards, workers.rank(), workers.size());
    std::vector<std::vector<torch::Tensor>> own;
    for (auto shard = static_cast<int>(shards.begin); shard < shards.end; ++shard)
      own.push_back(values_of(shard));
    const std::vector<double> losses(own.size(), -1e-300);
    EXPECT_EQ(sum.sum(own, losses), std::vector<double>(kShards, -1e-300));
    EXPECT_TRUE(torch::equal(own.front()[1], expected[1]));
    // 20 numbers of each shard, then half of the sums and the losses, to both.
    EXPECT_EQ(workers.numbers(), std::ssize(own) * 20 + 2 * (10 + 2 * std::ssize(own)));
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
