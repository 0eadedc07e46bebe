// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/norm_statistics.h"

#include <vector>

#include <torch/nn/modules/batchnorm.h>
#include <torch/utils.h>

namespace knuckle {
namespace {

template <class Norm>
std::vector<Norm*> norms_of(TrainableModule& network) {
  std::vector<Norm*> norms;
  for (const auto& module : network.modules(false)) {
    if (auto* const norm = module->as<Norm>()) norms.push_back(norm);
  }
  return norms;
}

template <class Norm>
void begin_measuring(const std::vector<Norm*>& norms) {
  for (Norm* const norm : norms) {
    norm->reset_running_stats();
    norm->options.momentum().reset();  // the mean over all batches, not a moving one
    norm->train();
  }
}

torch::Tensor inputs_of(TrainingBatch& batch, const torch::Device& device) {
  std::vector<int64_t> shape = batch.input_shape;
  shape.insert(shape.begin(), -1);
  const auto numbers = static_cast<int64_t>(batch.inputs.size());
  return torch::from_blob(batch.inputs.data(), {numbers}).view(shape).to(device);
}

}  // namespace

void measure_norm_statistics(TrainableModule& network, BatchPlan plan, int batches,
                             const torch::Device& device) {
  const torch::NoGradGuard no_gradient;
  const auto of_maps = norms_of<torch::nn::BatchNorm2dImpl>(network);
  const auto of_units = norms_of<torch::nn::BatchNorm1dImpl>(network);
  if (of_maps.empty() && of_units.empty()) return;
  network.eval();  // norms alone are in training: what they see in use was not thinned out by dropout
  begin_measuring(of_maps);
  begin_measuring(of_units);
  for (int i = 0; i < batches; ++i) {
    TrainingBatch batch = plan.batch(i);
    network.forward(inputs_of(batch, device));
  }
  // In training a norm divides by the deviation within its batch, but LibTorch keeps the unbiased variance:
  // too much by a part in as many as the batch has samples. Maps have thousands of numbers per sample.
  const auto count = static_cast<double>(plan.batch_size());
  for (torch::nn::BatchNorm1dImpl* const norm : of_units) norm->running_var.mul_((count - 1.0) / count);
  network.eval();
}

}  // namespace knuckle
