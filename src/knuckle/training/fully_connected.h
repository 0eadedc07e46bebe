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
  /// Prepares fresh weights for training: scales and shifts them so that each unit's sum has mean 0 and
  /// deviation 1 over `input` (N x inputs; Mishkin and Matas 2016), and gives those of the last layer the
  /// value 0. Else the first answers are much too large and alike for all patches, and what the optimiser's
  /// first steps do about it, moving thousands of inputs of a unit the same way, shuts hidden units for good.
  void fit_to(const torch::Tensor& input);
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
