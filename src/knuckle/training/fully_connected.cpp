// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/fully_connected.h"

#include <mutex>
#include <string>

#include <ATen/CPUGeneratorImpl.h>
#include <torch/nn/init.h>
#include <torch/utils.h>

namespace knuckle {
namespace {

constexpr double kLinearDeviation = 0.01;  // of the first weights of linear layers
constexpr double kLeastDeviation = 1e-6;   // of a unit that answers to its input

}  // namespace

FullyConnected::FullyConnected(int64_t inputs, const std::vector<Layer>& layers, double dropout)
    : dropout_(dropout), generator_(at::detail::createCPUGenerator()) {
  for (const Layer& layer : layers) {
    const std::string name = "layer" + std::to_string(linears_.size());
    linears_.push_back(register_module(name, torch::nn::Linear(inputs, layer.units)));
    activations_.push_back(layer.activation);
    torch::Tensor weight = linears_.back()->weight;
    if (layer.activation == Activation::linear) {
      torch::nn::init::normal_(weight, 0.0, kLinearDeviation);
    } else {
      torch::nn::init::kaiming_normal_(weight, 0.0, torch::kFanIn, torch::kReLU);
    }
    torch::nn::init::zeros_(linears_.back()->bias);
    inputs = layer.units;
  }
}

torch::Tensor FullyConnected::forward(const torch::Tensor& input) {
  torch::Tensor values = input;
  for (std::size_t i = 0; i < linears_.size(); ++i) {
    values = linears_[i]->forward(values);
    if (activations_[i] != Activation::linear) values = torch::relu(values);
    if (activations_[i] == Activation::hidden && is_training()) values = dropped_out(values);
  }
  return values;
}

void FullyConnected::fit_to(const torch::Tensor& input) {
  const torch::NoGradGuard no_gradient;
  torch::Tensor values = input;
  for (std::size_t i = 0; i + 1 < linears_.size(); ++i) {
    const torch::Tensor sums = linears_[i]->forward(values);
    const torch::Tensor mean = sums.mean(0);
    const torch::Tensor deviation = sums.std(0, /*unbiased=*/false);
    const torch::Tensor scale = torch::where(deviation > kLeastDeviation, 1.0 / deviation, 1.0);
    linears_[i]->weight.mul_(scale.unsqueeze(1));
    linears_[i]->bias.sub_(mean).mul_(scale);
    values = (sums - mean) * scale;
    if (activations_[i] != Activation::linear) values = torch::relu(values);
  }
  linears_.back()->weight.zero_();
}

torch::Tensor FullyConnected::dropped_out(const torch::Tensor& values) {
  if (dropout_ == 0.0) return values;
  const double kept = 1.0 - dropout_;
  const torch::Tensor mask = torch::empty(values.sizes()).bernoulli_(kept, generator_);
  return values * mask.to(values.options()) / kept;
}

void FullyConnected::seed_dropout(std::uint64_t seed) {
  const std::lock_guard lock(generator_.mutex());
  generator_.set_current_seed(seed);
}

}  // namespace knuckle
