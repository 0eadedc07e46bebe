// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <torch/types.h>

#include "knuckle/core/worker_group.h"
#include "knuckle/training/batch_loader.h"
#include "knuckle/training/gradient_sum.h"
#include "knuckle/training/tensor_pieces.h"
#include "knuckle/training/training_task.h"

namespace knuckle {

/// One network in training, worked on by several threads side by side: each works on its shard of the batch
/// with a copy that shares the weights and has gradients and batch norm statistics of its own. Several
/// workers have the same network, and each some of the shards.
class ShardedNetwork {
 public:
  /// `workers`: nullptr where one process has all shards.
  ShardedNetwork(const TrainingTask& task, std::uint64_t seed, int shards, const torch::Device& device,
                 WorkerGroup* workers = nullptr);

  /// From now on `backward` multiplies in numbers of this type; weights, gradients and loss keep theirs.
  void compute_in(torch::ScalarType type);

  /// The mean loss of a batch, of which `batch` has the samples of this process's shards; `seed` names the
  /// random numbers of its dropout. After it the gradients of `parameters()` are those of the mean loss,
  /// summed in the order of the shards: the same bits whoever works on which shard.
  double backward(TrainingBatch& batch, std::uint64_t seed);

  std::vector<torch::Tensor> parameters() const { return shards_.front()->parameters(); }
  std::vector<torch::Tensor> buffers() const { return shards_.front()->buffers(); }
  /// Gives the buffers of the first copy to all.
  void share_buffers();

 private:
  std::vector<double> backward_shards(TrainingBatch& batch, std::uint64_t seed);
  double backward_shard(TrainingBatch& batch, std::size_t shard);
  void sum_gradients();
  void average_buffers();
  /// Of all shards, with their gradients and statistics summed.
  std::vector<double> backward_among_workers(TrainingBatch& batch, std::uint64_t seed);

  torch::Device device_;
  int shard_count_;  // of all workers
  PartOfWork part_;  // of the shards, this process's
  std::vector<std::shared_ptr<TrainableModule>> shards_;
  std::optional<GradientSum> among_workers_;
  TensorPieces pieces_{{}};
};

}  // namespace knuckle
