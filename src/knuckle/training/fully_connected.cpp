// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/fully_connected.h"

#include <mutex>
#include <string>

#include <ATen/CPUGeneratorImpl.h>
#include <torch/nn/init.h>
#include <torch/utils.h>

#include "knuckle/net/layers/batch_norm.h"

namespace knuckle {
namespace {

constexpr double kLinearDeviation = 0.01;  // of the first weights of linear layers

}  // namespace

ConnectedUnit::ConnectedUnit(int64_t inputs, const ConnectedLayer& layer)
    : linear_(register_module(
          "linear",
          torch::nn::Linear(torch::nn::LinearOptions(inputs, layer.units).bias(!layer.has_norm())))) {
  if (layer.has_norm()) {
    norm_ = register_module(
        "norm", torch::nn::BatchNorm1d(torch::nn::BatchNorm1dOptions(layer.units).eps(kNormEpsilon)));
    torch::nn::init::kaiming_normal_(linear_->weight, 0.0, torch::kFanIn, torch::kReLU);
  } else {
    torch::nn::init::normal_(linear_->weight, 0.0, kLinearDeviation);
    torch::nn::init::zeros_(linear_->bias);
  }
}

torch::Tensor ConnectedUnit::forward(const torch::Tensor& input) {
  // Computed in the input's type whatever that of the weights.
  const torch::ScalarType type = input.scalar_type();
  const torch::Tensor bias = linear_->bias.defined() ? linear_->bias.to(type) : linear_->bias;
  const torch::Tensor sums = torch::linear(input, linear_->weight.to(type), bias);
  if (norm_.is_empty()) return sums;
  torch::Tensor result = norm_->forward(sums);
  return torch::relu_(result);
}

FullyConnected::FullyConnected(int64_t inputs, const std::vector<ConnectedLayer>& layers, double dropout)
    : dropout_(dropout), generator_(at::detail::createCPUGenerator()) {
  for (const ConnectedLayer& layer : layers) {
    const std::string name = "layer" + std::to_string(layers_.size());
    layers_.push_back({register_module(name, std::make_shared<ConnectedUnit>(inputs, layer)),
                       layer.activation == ConnectedLayer::Activation::hidden});
    inputs = layer.units;
  }
  const torch::NoGradGuard no_gradient;
  for (torch::Tensor& parameter : layers_.back().unit->parameters()) {
    if (layers.back().activation == ConnectedLayer::Activation::linear) parameter.zero_();
  }
}

torch::Tensor FullyConnected::forward(const torch::Tensor& input) {
  torch::Tensor values = input;
  for (const Layer& layer : layers_) {
    values = layer.unit->forward(values);
    if (layer.has_dropout && is_training()) values = dropped_out(values);
  }
  return values;
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
