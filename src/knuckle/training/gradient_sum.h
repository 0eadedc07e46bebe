// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include <torch/types.h>

#include "knuckle/core/worker_group.h"
#include "knuckle/training/shard_sum.h"
#include "knuckle/training/side_stream.h"

namespace torch::autograd {
struct Node;
}

namespace knuckle {

/// Sums the gradients of several workers' shards while they are computed: those of the last layers, which are
/// ready first, are on their way while those of the layers before are worked on. Each number is summed in the
/// order of the shards, so that its bits depend neither on the number of workers nor on what goes with it.
class GradientSum {
 public:
  /// So many bytes of a shard's gradients go together, and the first layers' with what is known at the end: a
  /// message of 4 MB takes ten times as long to send as to announce.
  static constexpr std::int64_t kPartBytes = std::int64_t{4} << 20;

  /// `parameters`: of each shard of this worker, in the order in which layers use them; all have gradients
  /// after each step. `workers` has to live as long as this.
  GradientSum(WorkerGroup& workers, int shards, const torch::Device& device,
              std::vector<std::vector<torch::Tensor>> parameters, std::int64_t part_bytes = kPartBytes);
  ~GradientSum();
  GradientSum(const GradientSum&) = delete;
  GradientSum& operator=(const GradientSum&) = delete;

  /// Calls `backward`, which computes the gradients of this worker's shards anew and returns their losses.
  /// Sets the first shard's gradients to the sums of all workers' shards, and the first list of `others`
  /// (tensors of each shard, which are known then) to theirs. Returns the losses of all shards. Throws what
  /// `backward` throws, and as `WorkerGroup::exchange` does.
  std::vector<double> sum(const std::function<std::vector<double>()>& backward,
                          std::vector<std::vector<torch::Tensor>> others);

 private:
  /// Parameters whose gradients go together.
  struct Part {
    std::vector<std::size_t> parameters;
    DeviceMark known;         ///< when they are
    std::size_t missing = 0;  ///< gradients of all shards that are not there yet
  };

  void watch_gradients(std::size_t part);
  void expect_all();
  void count_gradient(std::size_t part);
  void sum_parts();
  bool wait_for(const Part& part);
  void end_early();
  std::vector<std::vector<torch::Tensor>> gradients_of(const std::vector<std::size_t>& which) const;

  torch::Device device_;
  ShardSum sum_;
  SideStream beside_;
  DeviceMark summed_;
  std::vector<std::vector<torch::Tensor>> parameters_;
  std::vector<Part> parts_;
  std::vector<std::size_t> first_layers_;
  std::vector<std::pair<std::shared_ptr<torch::autograd::Node>, std::uintptr_t>> hooks_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_over_ = false;
};

}  // namespace knuckle
