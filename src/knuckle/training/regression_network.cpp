// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/regression_network.h"

#include <torch/utils.h>

namespace knuckle {

torch::Tensor RegressionNetwork::loss(const torch::Tensor& output, const torch::Tensor& /*patches*/,
                                      const torch::Tensor& joints) {
  const torch::Tensor is_known = torch::isfinite(joints).all(-1).to(output.scalar_type());
  const torch::Tensor truth = torch::nan_to_num(joints, 0.0, 0.0, 0.0);
  const torch::Tensor squares = (output.view_as(truth) - truth).square().sum(-1);
  return (squares * is_known).sum() / is_known.sum().clamp_min(1.0);
}

NetworkAnswer RegressionNetwork::decode(const torch::Tensor& output, const torch::Tensor& /*patches*/) {
  return {output.view({output.size(0), -1, 3}), {}};
}

}  // namespace knuckle
