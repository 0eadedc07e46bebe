// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <optional>

#include <torch/nn/module.h>
#include <torch/types.h>

namespace knuckle {

/// An architecture with its weights and its loss: all that a training needs to know of a network.
class TrainableModule : public torch::nn::Module {
 public:
  /// `inputs`: N x the shape of one input. What comes out is the architecture's own matter.
  virtual torch::Tensor forward(const torch::Tensor& inputs) = 0;
  /// The mean loss of a batch, a scalar. `targets`: N x the shape of one sample's truth, in which NaN is not
  /// known and does not count.
  virtual torch::Tensor loss(const torch::Tensor& output, const torch::Tensor& inputs,
                             const torch::Tensor& targets) = 0;
  /// Names the random numbers that the next `forward` in training draws, where the architecture draws any.
  virtual void seed_dropout(std::uint64_t /*seed*/) {}

  /// From now on `forward` multiplies and keeps its features in numbers of this type; weights, loss and what
  /// comes out stay in the inputs' type.
  void compute_in(torch::ScalarType type) { type_ = type; }

 protected:
  /// The values in the type to compute in.
  torch::Tensor to_compute(const torch::Tensor& values) const { return type_ ? values.to(*type_) : values; }

 private:
  std::optional<torch::ScalarType> type_;
};

/// Lays out the weights of convolutions for channels that lie side by side, which is faster.
void lay_out_for_channels_last(TrainableModule& network);

}  // namespace knuckle
