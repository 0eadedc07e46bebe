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

/// Fully connected layers, one behind another, with dropout behind the hidden ones.
///
/// Each call in training draws anew which units it keeps, the same for all its samples (Graham et al. 2015,
/// batchwise dropout): so the others' weights are not read, and two layers that drop a half each multiply a
/// quarter of their matrix.
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
  /// Ascending indices of the units that this call keeps.
  torch::Tensor draw_kept(int64_t units);

  std::vector<torch::nn::Linear> linears_;
  std::vector<Activation> activations_;
  double dropout_;
  at::Generator generator_;
};

}  // namespace knuckle
