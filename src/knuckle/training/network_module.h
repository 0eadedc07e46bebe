// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <torch/nn/module.h>
#include <torch/types.h>

#include "knuckle/net/network_options.h"

namespace knuckle {

/// What a network says about a batch of patches.
struct NetworkAnswer {
  torch::Tensor joints;      ///< N x J x 3: u, v, d in patch coordinates
  torch::Tensor confidence;  ///< N x J, in [0, 1]; undefined where the architecture gives none
};

/// An architecture with its weights, its loss, and the way from its output to joints.
class NetworkModule : public torch::nn::Module {
 public:
  /// `patches`: N x 1 x size x size. What comes out is the architecture's own matter.
  virtual torch::Tensor forward(const torch::Tensor& patches) = 0;
  /// The mean loss of a batch, a scalar. `joints`: N x J x 3; one that is not known is NaN and does not
  /// count.
  virtual torch::Tensor loss(const torch::Tensor& output, const torch::Tensor& patches,
                             const torch::Tensor& joints) = 0;
  virtual NetworkAnswer decode(const torch::Tensor& output, const torch::Tensor& patches) = 0;
  /// Names the random numbers that the next `forward` in training draws, where the architecture draws any.
  virtual void seed_dropout(std::uint64_t /*seed*/) {}

  /// From now on `forward` multiplies and keeps its features in numbers of this type; weights, loss and what
  /// comes out stay in the patches' type.
  void compute_in(torch::ScalarType type) { type_ = type; }

  int patch_size() const { return patch_size_; }

 protected:
  explicit NetworkModule(int patch_size) : patch_size_(patch_size) {}
  /// The values in the type to compute in.
  torch::Tensor to_compute(const torch::Tensor& values) const { return type_ ? values.to(*type_) : values; }

 private:
  int patch_size_;
  std::optional<torch::ScalarType> type_;
};

/// Builds the network with random weights that depend on `seed` alone.
std::shared_ptr<NetworkModule> make_network(const NetworkOptions& options, std::uint64_t seed);

}  // namespace knuckle
