// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <torch/types.h>

#include "knuckle/core/worker_group.h"

namespace knuckle {

/// Sums what the shards of several workers have found, number by number in the order of the shards, whoever
/// has which of them: the bits of the sum do not depend on the number of workers.
///
/// Each worker gets all shards' values of its own part of the numbers, sums them, and hands the sums to all.
/// With L numbers, S shards and N workers each sends about S / N (1 - 1/N) L and then (1 - 1/N) L of them.
class ShardSum {
 public:
  /// `workers` has to live as long as this. The shards are dealt by `part_of_worker`.
  ShardSum(WorkerGroup& workers, int shards) : workers_(workers), shards_(shards) {}

  /// `own`: for each shard of this worker a list of tensors of 32-bit numbers, of the same shapes for all
  /// shards of all workers. Sets the first list to the sums. Returns the losses of all shards, of which
  /// `losses` are this worker's.
  std::vector<double> sum(const std::vector<std::vector<torch::Tensor>>& own, std::span<const double> losses);

 private:
  PartOfWork shards_of(int worker) const { return part_of_worker(shards_, worker, workers_.size()); }
  std::vector<float> summed_part(const std::vector<std::vector<float>>& own, std::int64_t length);
  std::vector<double> share(const std::vector<float>& part, std::span<const double> losses,
                            std::vector<float>& whole);

  WorkerGroup& workers_;
  int shards_;
};

}  // namespace knuckle
