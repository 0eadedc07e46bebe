// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <ATen/core/Generator.h>
#include <torch/nn/module.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/linear.h>

#include "knuckle/net/paper_architecture.h"

namespace knuckle {

/// A fully connected layer: a hidden one with batch norm (in place of a bias) and ReLU, a linear one with a
/// bias.
///
/// Without the norm AdamW shuts hidden units for good. Its steps move each of a unit's thousands of inputs by
/// the same amount, and inputs that come out of a ReLU all have the same sign: where the error has a mean, a
/// single step moves a unit's sum by more than it differs between patches.
class ConnectedUnit final : public torch::nn::Module {
 public:
  ConnectedUnit(int64_t inputs, const ConnectedLayer& layer);
  torch::Tensor forward(const torch::Tensor& input);

 private:
  torch::nn::Linear linear_;
  torch::nn::BatchNorm1d norm_{nullptr};  // empty where the layer is linear
};

/// Fully connected layers, one after another. The last one answers 0 at first.
class FullyConnected final : public torch::nn::Module {
 public:
  FullyConnected(int64_t inputs, const std::vector<ConnectedLayer>& layers, double dropout);

  /// N x inputs -> N x units of the last layer. N has to be at least 2 in training.
  torch::Tensor forward(const torch::Tensor& input);
  /// Names the random numbers of the next dropouts: LibTorch's own would depend on which thread comes first.
  void seed_dropout(std::uint64_t seed);

 private:
  torch::Tensor dropped_out(const torch::Tensor& values);

  struct Layer {
    std::shared_ptr<ConnectedUnit> unit;
    bool has_dropout;
  };
  std::vector<Layer> layers_;
  double dropout_;
  at::Generator generator_;
};

}  // namespace knuckle
