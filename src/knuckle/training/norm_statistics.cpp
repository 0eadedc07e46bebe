// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/norm_statistics.h"

#include <torch/nn/modules/batchnorm.h>
#include <torch/utils.h>

namespace knuckle {
namespace {

std::vector<torch::nn::BatchNorm2dImpl*> norms_of(NetworkModule& network) {
  std::vector<torch::nn::BatchNorm2dImpl*> norms;
  for (const auto& module : network.modules(false)) {
    if (auto* norm = module->as<torch::nn::BatchNorm2dImpl>()) norms.push_back(norm);
  }
  return norms;
}

torch::Tensor patches_of(TrainingBatch& batch, int64_t size, const torch::Device& device) {
  const auto count = static_cast<int64_t>(batch.patches.size()) / (size * size);
  return torch::from_blob(batch.patches.data(), {count, 1, size, size}).to(device);
}

}  // namespace

void measure_norm_statistics(NetworkModule& network, BatchPlan plan, int batches,
                             const torch::Device& device) {
  const torch::NoGradGuard no_gradient;
  const std::vector<torch::nn::BatchNorm2dImpl*> norms = norms_of(network);
  if (norms.empty()) return;
  for (torch::nn::BatchNorm2dImpl* norm : norms) {
    norm->reset_running_stats();
    norm->options.momentum().reset();  // the mean over all batches, not a moving one
  }
  network.train();
  for (int i = 0; i < batches; ++i) {
    TrainingBatch batch = plan.batch(i);
    network.forward(patches_of(batch, network.patch_size(), device));
  }
  network.eval();
}

}  // namespace knuckle
