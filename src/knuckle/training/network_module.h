// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <memory>

#include <torch/types.h>

#include "knuckle/net/network_options.h"
#include "knuckle/training/trainable_module.h"

namespace knuckle {

/// What a network says about a batch of patches.
struct NetworkAnswer {
  torch::Tensor joints;      ///< N x J x 3: u, v, d in patch coordinates
  torch::Tensor confidence;  ///< N x J, in [0, 1]; undefined where the architecture gives none
  torch::Tensor right_hand =
      {};  ///< N, in [0, 1]: how likely a right hand; undefined where the network cannot tell
  torch::Tensor hand = {};  ///< the same of a hand at all
};

/// An architecture that infers joints from patches, N x 1 x size x size: with its weights, its loss against
/// N x J x 3 joints, and the way from its output to joints.
class NetworkModule : public TrainableModule {
 public:
  virtual NetworkAnswer decode(const torch::Tensor& output, const torch::Tensor& patches) = 0;

  int patch_size() const { return patch_size_; }

 protected:
  explicit NetworkModule(int patch_size) : patch_size_(patch_size) {}

 private:
  int patch_size_;
};

/// Builds the network with random weights that depend on `seed` alone.
std::shared_ptr<NetworkModule> make_network(const NetworkOptions& options, std::uint64_t seed);

}  // namespace knuckle
