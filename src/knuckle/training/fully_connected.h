// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <vector>

#include <ATen/core/Generator.h>
#include <torch/nn/module.h>
#include <torch/nn/modules/linear.h>

#include "knuckle/net/paper_architecture.h"

namespace knuckle {

/// Fully connected layers, one behind another.
class FullyConnected final : public torch::nn::Module {
 public:
  using Layer = ConnectedLayer;
  using Activation = ConnectedLayer::Activation;

  FullyConnected(int64_t inputs, const std::vector<Layer>& layers, double dropout);

  /// N x inputs -> N x units of the last layer.
  torch::Tensor forward(const torch::Tensor& input);
  /// Names the random numbers of the next dropouts: LibTorch's own would depend on which thread comes first.
  void seed_dropout(std::uint64_t seed);

 private:
  torch::Tensor dropped_out(const torch::Tensor& values);

  std::vector<torch::nn::Linear> linears_;
  std::vector<Activation> activations_;
  double dropout_;
  at::Generator generator_;
};

}  // namespace knuckle
