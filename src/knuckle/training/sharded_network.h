// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <memory>
#include <vector>

#include <torch/types.h>

#include "knuckle/training/batch_loader.h"
#include "knuckle/training/tensor_pieces.h"
#include "knuckle/training/training_task.h"

namespace knuckle {

/// One network in training, worked on by several threads side by side: each works on its shard of the batch
/// with a copy that shares the weights and has gradients and batch norm statistics of its own.
class ShardedNetwork {
 public:
  ShardedNetwork(const TrainingTask& task, std::uint64_t seed, int shards, const torch::Device& device);

  /// From now on `backward` multiplies in numbers of this type; weights, gradients and loss keep theirs.
  void compute_in(torch::ScalarType type);

  /// The mean loss of a batch; `seed` names the random numbers of its dropout. Behind it the gradients of
  /// `parameters()` are those of the mean loss, summed in the order of the shards.
  double backward(TrainingBatch& batch, std::uint64_t seed);

  std::vector<torch::Tensor> parameters() const { return shards_.front()->parameters(); }
  std::vector<torch::Tensor> buffers() const { return shards_.front()->buffers(); }
  /// Gives the buffers of the first copy to all.
  void share_buffers();

 private:
  double backward_shard(TrainingBatch& batch, std::size_t shard);
  void sum_gradients();
  void average_buffers();

  torch::Device device_;
  std::vector<std::shared_ptr<TrainableModule>> shards_;
  TensorPieces pieces_{{}};
};

}  // namespace knuckle
