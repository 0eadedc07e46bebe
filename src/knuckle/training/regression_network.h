// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <memory>

#include "knuckle/training/convolution_banks.h"
#include "knuckle/training/fully_connected.h"
#include "knuckle/training/network_module.h"

namespace knuckle {

/// Direct regression of all joints (Riegler et al. 2015, section 3.3): `regression`; through a linear
/// sub-space, `pca`; through a learned non-linear one, `autoencoder`.
///
/// Output: N x 3J, u v d of each joint. The loss is the mean squared distance of the joints that are known.
class RegressionNetwork final : public NetworkModule {
 public:
  explicit RegressionNetwork(const NetworkOptions& options);

  torch::Tensor forward(const torch::Tensor& patches) override;
  torch::Tensor loss(const torch::Tensor& output, const torch::Tensor& patches,
                     const torch::Tensor& joints) override;
  NetworkAnswer decode(const torch::Tensor& output, const torch::Tensor& patches) override;
  void seed_dropout(std::uint64_t seed) override { layers_->seed_dropout(seed); }

 private:
  std::shared_ptr<ConvolutionBanks> banks_;
  std::shared_ptr<FullyConnected> layers_;
};

}  // namespace knuckle
