// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <memory>

#include "knuckle/training/convolution_banks.h"
#include "knuckle/training/fully_connected.h"
#include "knuckle/training/network_module.h"

namespace knuckle {

/// What the paper's five networks share (Riegler et al. 2015, section 3): three banks of convolutions and
/// fully connected layers after them. Output: N x units of the last layer.
class PaperNetwork : public NetworkModule {
 public:
  torch::Tensor forward(const torch::Tensor& patches) override {
    return layers_->forward(to_compute(banks_->forward(patches))).to(patches.scalar_type());
  }
  void seed_dropout(std::uint64_t seed) override { layers_->seed_dropout(seed); }

 protected:
  explicit PaperNetwork(const NetworkOptions& options);

 private:
  std::shared_ptr<ConvolutionBanks> banks_;
  std::shared_ptr<FullyConnected> layers_;
};

}  // namespace knuckle
