// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <torch/types.h>

#include "knuckle/core/worker_group.h"
#include "knuckle/workers/tensor_exchange.h"

namespace knuckle {

/// Sums what the shards of several workers have found, number by number in the order of the shards, whoever
/// has which of them: the bits of the sum do not depend on the number of workers.
///
/// Each worker gets all shards' values of its own part of the numbers, sums them, and hands the sums to all.
/// With L numbers, S shards and N workers each sends about S / N (1 - 1/N) L and then (1 - 1/N) L of them.
/// Where the workers are DeviceWorkers the numbers go from where they lie to where they shall lie.
class ShardSum {
 public:
  /// `workers` has to live as long as this. The shards are dealt by `part_of_worker`; their numbers lie on
  /// `device`.
  ShardSum(WorkerGroup& workers, int shards, const torch::Device& device = torch::kCPU);

  /// `own`: for each shard of this worker a list of tensors of 32-bit numbers, of the same shapes for all
  /// shards of all workers. Sets the first list to the sums. Returns the losses of all shards, of which
  /// `losses` are this worker's; none where no worker tells them.
  std::vector<double> sum(const std::vector<std::vector<torch::Tensor>>& own, std::span<const double> losses);

 private:
  PartOfWork shards_of(int worker) const { return part_of_worker(shards_, worker, workers_.size()); }
  torch::Tensor summed_part(const std::vector<torch::Tensor>& own);
  std::vector<double> share(const torch::Tensor& part, std::span<const double> losses, std::int64_t length,
                            torch::Tensor& whole);

  WorkerGroup& workers_;
  int shards_;
  std::unique_ptr<TensorExchange> exchange_;
};

}  // namespace knuckle
