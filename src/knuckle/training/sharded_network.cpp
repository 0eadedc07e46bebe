// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/sharded_network.h"

#include <numeric>

#include <torch/utils.h>

#include "knuckle/core/parallel.h"
#include "knuckle/training/torch_threads.h"

namespace knuckle {

ShardedNetwork::ShardedNetwork(const TrainingTask& task, std::uint64_t seed, int shards,
                               const torch::Device& device, WorkerGroup* workers)
    : device_(device), shard_count_(shards), part_{0, shards} {
  if (workers != nullptr) part_ = part_of_worker(shards, workers->rank(), workers->size());
  for (std::int64_t i = part_.begin; i < part_.end; ++i) {
    shards_.push_back(task.make_module(seed));
    shards_.back()->to(device);
    shards_.back()->train();
    const std::vector<torch::Tensor> own = shards_.back()->parameters();
    const std::vector<torch::Tensor> shared = parameters();
    for (std::size_t p = 0; p < own.size(); ++p) own[p].set_data(shared[p].detach());
  }
  pieces_ = TensorPieces(parameters());
  if (workers == nullptr) return;
  std::vector<std::vector<torch::Tensor>> parameters;
  for (const std::shared_ptr<TrainableModule>& shard : shards_) parameters.push_back(shard->parameters());
  among_workers_.emplace(*workers, shards, device, std::move(parameters));
}

void ShardedNetwork::compute_in(torch::ScalarType type) {
  for (const std::shared_ptr<TrainableModule>& shard : shards_) shard->compute_in(type);
}

double ShardedNetwork::backward(TrainingBatch& batch, std::uint64_t seed) {
  std::vector<double> losses;
  if (among_workers_) {
    losses = backward_among_workers(batch, seed);
  } else {
    losses = backward_shards(batch, seed);
    sum_gradients();
    average_buffers();
  }
  return std::accumulate(losses.begin(), losses.end(), 0.0);
}

std::vector<double> ShardedNetwork::backward_shards(TrainingBatch& batch, std::uint64_t seed) {
  std::vector<double> losses(shards_.size());
  parallel_for(std::ssize(shards_), [&](std::int64_t i) {
    const auto shard = static_cast<std::size_t>(i);
    shards_[shard]->seed_dropout(derived_seed(seed, static_cast<std::uint64_t>(part_.begin + i)));
    losses[shard] = backward_shard(batch, shard);
  });
  return losses;
}

double ShardedNetwork::backward_shard(TrainingBatch& batch, std::size_t shard) {
  use_calling_thread_alone();
  TrainableModule& network = *shards_[shard];
  for (torch::Tensor& parameter : network.parameters()) parameter.mutable_grad() = torch::Tensor();
  const std::size_t parts = shards_.size();
  const auto part_of = [&](std::vector<float>& values, std::vector<int64_t> shape) {
    const std::size_t size = values.size() / parts;
    shape.insert(shape.begin(), -1);
    return torch::from_blob(values.data() + shard * size, {static_cast<int64_t>(size)})
        .view(shape)
        .to(device_);
  };
  const torch::Tensor inputs = part_of(batch.inputs, batch.input_shape);
  const torch::Tensor targets = part_of(batch.targets, batch.target_shape);
  const torch::Tensor loss =
      network.loss(network.forward(inputs), inputs, targets) / static_cast<double>(shard_count_);
  loss.backward();
  return loss.item<double>();
}

void ShardedNetwork::sum_gradients() {
  if (shards_.size() == 1) return;
  std::vector<std::vector<torch::Tensor>> gradients;
  for (const std::shared_ptr<TrainableModule>& shard : shards_) {
    std::vector<torch::Tensor>& own = gradients.emplace_back();
    for (const torch::Tensor& parameter : shard->parameters()) own.push_back(parameter.grad());
  }
  pieces_.for_each(gradients, [](int64_t /*index*/, std::vector<torch::Tensor>& pieces) {
    for (std::size_t shard = 1; shard < pieces.size(); ++shard) pieces[0].add_(pieces[shard]);
  });
}

std::vector<double> ShardedNetwork::backward_among_workers(TrainingBatch& batch, std::uint64_t seed) {
  std::vector<std::vector<torch::Tensor>> statistics;
  for (const std::shared_ptr<TrainableModule>& shard : shards_) {
    std::vector<torch::Tensor>& own = statistics.emplace_back();
    for (const torch::Tensor& buffer : shard->buffers()) {
      if (buffer.is_floating_point()) own.push_back(buffer);
    }
  }
  std::vector<double> losses =
      among_workers_->sum([&] { return backward_shards(batch, seed); }, std::move(statistics));
  const torch::NoGradGuard no_gradient;
  for (const torch::Tensor& buffer : buffers()) {
    if (buffer.is_floating_point()) buffer.div_(static_cast<double>(shard_count_));
  }
  share_buffers();
  return losses;
}

void ShardedNetwork::average_buffers() {
  const torch::NoGradGuard no_gradient;
  const std::vector<torch::Tensor> means = buffers();
  for (std::size_t shard = 1; shard < shards_.size(); ++shard) {
    const std::vector<torch::Tensor> own = shards_[shard]->buffers();
    for (std::size_t b = 0; b < means.size(); ++b) {
      if (means[b].is_floating_point()) means[b].add_(own[b]);
    }
  }
  for (const torch::Tensor& mean : means) {
    if (mean.is_floating_point()) mean.div_(static_cast<double>(shards_.size()));
  }
  share_buffers();
}

void ShardedNetwork::share_buffers() {
  const torch::NoGradGuard no_gradient;
  const std::vector<torch::Tensor> from = buffers();
  for (std::size_t shard = 1; shard < shards_.size(); ++shard) {
    const std::vector<torch::Tensor> own = shards_[shard]->buffers();
    for (std::size_t b = 0; b < from.size(); ++b) own[b].copy_(from[b]);
  }
}

}  // namespace knuckle
