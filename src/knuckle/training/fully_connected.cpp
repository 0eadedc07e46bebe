// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/fully_connected.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <string>
#include <tuple>

#include <ATen/CPUGeneratorImpl.h>
#include <torch/nn/init.h>
#include <torch/utils.h>

#include "knuckle/training/kept_weights.h"

namespace knuckle {
namespace {

constexpr double kLinearDeviation = 0.01;  // of the first weights of linear layers

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
  torch::Tensor kept_inputs;  // not defined: all
  for (std::size_t i = 0; i < linears_.size(); ++i) {
    const torch::nn::LinearImpl& linear = *linears_[i];
    const bool is_dropped =
        is_training() && dropout_ > 0.0 && activations_[i] == Activation::hidden && i + 1 < linears_.size();
    const torch::Tensor kept = is_dropped ? draw_kept(linear.weight.size(0)) : torch::Tensor();
    const torch::Tensor bias =
        is_dropped ? linear.bias.index_select(0, kept.to(linear.bias.device())) : linear.bias;
    values = torch::linear(values, kept_weights(linear.weight, kept, kept_inputs), bias);
    if (activations_[i] != Activation::linear) values = torch::relu(values);
    if (is_dropped) {
      values = values * (static_cast<double>(linear.weight.size(0)) / static_cast<double>(kept.numel()));
    }
    kept_inputs = kept;
  }
  return values;
}

torch::Tensor FullyConnected::draw_kept(int64_t units) {
  const auto count = std::max<int64_t>(1, std::llround((1.0 - dropout_) * static_cast<double>(units)));
  const torch::Tensor order = torch::randperm(units, generator_);
  return std::get<0>(order.narrow(0, 0, count).sort());
}

void FullyConnected::seed_dropout(std::uint64_t seed) {
  const std::lock_guard lock(generator_.mutex());
  generator_.set_current_seed(seed);
}

}  // namespace knuckle
