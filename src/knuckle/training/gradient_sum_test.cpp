// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/gradient_sum.h"

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include <torch/utils.h>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/worker_group_testing.h"

namespace knuckle {
namespace {

using testing::ThreadWorkers;
using Tensors = std::vector<torch::Tensor>;

constexpr int kShards = 5;
constexpr int kLayers = 4;
constexpr int kWidth = 6;

/// Numbers of very different sizes, whose sum hangs on its order.
torch::Tensor numbers(std::vector<int64_t> shape, std::uint64_t stream) {
  Random random(11, stream);
  torch::Tensor tensor = torch::zeros(shape);
  auto* const values = tensor.data_ptr<float>();
  for (int64_t i = 0; i < tensor.numel(); ++i)
    values[i] = static_cast<float>(random.uniform(-1.0, 1.0) * std::pow(10.0, random.uniform(-2.0, 2.0)));
  return tensor;
}

/// Layers that multiply by a matrix; all shards have the same weights.
Tensors layers() {
  Tensors weights;
  for (int layer = 0; layer < kLayers; ++layer) {
    weights.push_back(numbers({kWidth, kWidth}, static_cast<std::uint64_t>(layer)).requires_grad_());
  }
  return weights;
}

/// Computes a shard's gradients. `at_first_layer` is called when those of all other layers are there.
double backward(Tensors& weights, int shard, const std::function<void()>& at_first_layer = {}) {
  for (torch::Tensor& weight : weights) weight.mutable_grad() = torch::Tensor();
  torch::Tensor values = numbers({3, kWidth}, 100 + static_cast<std::uint64_t>(shard)).mm(weights.front());
  if (at_first_layer) {
    values.register_hook([&](const torch::Tensor& gradient) {
      at_first_layer();
      return gradient;
    });
  }
  for (int layer = 1; layer < kLayers; ++layer) values = values.mm(weights[static_cast<std::size_t>(layer)]);
  const torch::Tensor loss = values.sin().sum();
  loss.backward();
  return loss.item<double>();
}

/// What one process finds: gradients summed in the order of the shards, then a statistic.
Tensors summed_in_order() {
  Tensors sum;
  for (int shard = 0; shard < kShards; ++shard) {
    Tensors weights = layers();
    backward(weights, shard);
    Tensors terms;
    for (const torch::Tensor& weight : weights) terms.push_back(weight.grad());
    terms.push_back(numbers({7}, 200 + static_cast<std::uint64_t>(shard)));
    if (sum.empty()) {
      sum = terms;
      continue;
    }
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i].add_(terms[i]);
  }
  return sum;
}

/// A worker's shards, and the sum of their gradients.
struct Shards {
  Shards(WorkerGroup& workers, std::int64_t part_bytes)
      : own(part_of_worker(kShards, workers.rank(), workers.size())) {
    for (std::int64_t i = 0; i < own.size(); ++i) weights.push_back(layers());
    sum = std::make_unique<GradientSum>(workers, kShards, torch::kCPU, weights, part_bytes);
  }

  std::vector<double> backward_all(const std::function<void()>& at_first_layer = {}) {
    std::vector<double> losses;
    for (std::int64_t i = 0; i < own.size(); ++i) {
      const auto shard = static_cast<std::size_t>(i);
      losses.push_back(backward(weights[shard], static_cast<int>(own.begin + i), at_first_layer));
    }
    return losses;
  }
  std::vector<Tensors> statistics() const {
    std::vector<Tensors> values;
    for (std::int64_t shard = own.begin; shard < own.end; ++shard)
      values.push_back({numbers({7}, 200 + static_cast<std::uint64_t>(shard))});
    return values;
  }

  PartOfWork own;
  std::vector<Tensors> weights;
  std::unique_ptr<GradientSum> sum;
};

class GradientSumOf : public ::testing::TestWithParam<std::pair<int, std::int64_t>> {};

// Each layer by itself, two at a time, and all at the end.
INSTANTIATE_TEST_SUITE_P(WorkersAndBytes, GradientSumOf,
                         ::testing::Values(std::pair(1, 1), std::pair(2, 1), std::pair(3, 150),
                                           std::pair(5, 1), std::pair(2, 1000)));

TEST_P(GradientSumOf, HasTheBitsOfOneProcess) {
  const auto [count, part_bytes] = GetParam();
  const Tensors expected = summed_in_order();
  ThreadWorkers(count).run([&, part_bytes = part_bytes](WorkerGroup& workers) {
    Shards shards(workers, part_bytes);
    for (int step = 0; step < 3; ++step) {
      const std::vector<Tensors> statistics = shards.statistics();
      const std::vector<double> losses = shards.sum->sum([&] { return shards.backward_all(); }, statistics);
      ASSERT_EQ(losses.size(), static_cast<std::size_t>(kShards));
      for (int shard = 0; shard < kShards; ++shard) {
        Tensors weights = layers();
        EXPECT_EQ(losses[static_cast<std::size_t>(shard)], backward(weights, shard));
      }
      for (std::size_t layer = 0; layer < kLayers; ++layer)
        EXPECT_TRUE(torch::equal(shards.weights.front()[layer].grad(), expected[layer])) << layer;
      EXPECT_TRUE(torch::equal(statistics.front()[0], expected.back()));
    }
  });
}

/// Counts what another group of workers sends.
class CountingWorkers final : public WorkerGroup {
 public:
  explicit CountingWorkers(WorkerGroup& workers) : workers_(workers) {}

  int rank() const override { return workers_.rank(); }
  int size() const override { return workers_.size(); }
  double seconds_in_exchange() const override { return 0.0; }
  std::int64_t bytes_sent() const override { return 0; }
  std::vector<std::byte> exchange(Messages sent, const std::vector<std::int64_t>& sizes) override {
    std::vector<std::byte> received = workers_.exchange(std::move(sent), sizes);
    ++exchanges_;
    return received;
  }
  /// Waits until there were so many; false after 20 s.
  bool waits_for(int exchanges) const {
    for (int look = 0; look < 20000 && exchanges_ < exchanges; ++look)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return exchanges_ >= exchanges;
  }

 private:
  WorkerGroup& workers_;
  std::atomic<int> exchanges_ = 0;
};

TEST(GradientSum, SendsTheLastLayersWhileTheFirstIsWorkedOn) {
  ThreadWorkers(2).run([](WorkerGroup& others) {
    CountingWorkers workers(others);
    Shards shards(workers, 1);
    std::int64_t shard = 0;
    const auto at_first_layer = [&] {
      if (++shard < shards.own.size()) return;
      EXPECT_TRUE(workers.waits_for(2 * (kLayers - 1))) << "two exchanges a sum";
    };
    shards.sum->sum([&] { return shards.backward_all(at_first_layer); }, shards.statistics());
  });
}

TEST(GradientSum, EndsWithWhatBackwardThrowsAndGoesOnAfterwards) {
  const Tensors expected = summed_in_order();
  ThreadWorkers(1).run([&](WorkerGroup& workers) {
    Shards shards(workers, 1);
    const auto failing = [&]() -> std::vector<double> {
      backward(shards.weights.front(), 0);
      throw std::runtime_error("out of memory");
    };
    EXPECT_THROW(shards.sum->sum(failing, shards.statistics()), std::runtime_error);
    shards.sum->sum([&] { return shards.backward_all(); }, shards.statistics());
    EXPECT_TRUE(torch::equal(shards.weights.front()[1].grad(), expected[1]));
  });
}

TEST(GradientSum, EndsWhereAWorkerIsLostOnTheWay) {
  testing::ToldWorkers workers({});
  Shards shards(workers, 1);
  EXPECT_THROW(shards.sum->sum([&] { return shards.backward_all(); }, shards.statistics()),
               std::runtime_error);
}

}  // namespace
}  // namespace knuckle
