// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include "knuckle/training/paper_network.h"

namespace knuckle {

/// Direct regression of all joints (Riegler et al. 2015, section 3.3): `regression`; through a linear
/// sub-space, `pca`; through a learned non-linear one, `autoencoder`.
///
/// Output: N x 3J, u v d of each joint. The loss is the mean squared distance of the joints that are known.
class RegressionNetwork final : public PaperNetwork {
 public:
  explicit RegressionNetwork(const NetworkOptions& options) : PaperNetwork(options) {}

  torch::Tensor loss(const torch::Tensor& output, const torch::Tensor& patches,
                     const torch::Tensor& joints) override;
  NetworkAnswer decode(const torch::Tensor& output, const torch::Tensor& patches) override;
};

}  // namespace knuckle
