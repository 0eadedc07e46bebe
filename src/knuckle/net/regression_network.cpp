// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/regression_network.h"

#include <torch/utils.h>

namespace knuckle {
namespace {

using Activation = FullyConnected::Activation;

/// The layers behind the banks, by the architecture's name.
std::vector<FullyConnected::Layer> layers_of(const NetworkOptions& options) {
  const FullyConnected::Layer hidden{options.paper.hidden_units, Activation::hidden};
  const FullyConnected::Layer joints{3 * options.joint_count(), Activation::linear};
  const int64_t subspace = options.paper.subspace_units;
  if (options.architecture == "pca") return {hidden, hidden, {subspace, Activation::linear}, joints};
  if (options.architecture == "autoencoder") {
    return {hidden, hidden, {subspace, Activation::relu}, hidden, joints};
  }
  return {hidden, hidden, joints};
}

}  // namespace

RegressionNetwork::RegressionNetwork(const NetworkOptions& options)
    : NetworkModule(options.patch.size_px),
      banks_(register_module(
          "banks", std::make_shared<ConvolutionBanks>(options.patch.size_px, options.paper.first_maps,
                                                      options.paper.second_maps))),
      layers_(register_module("layers",
                              std::make_shared<FullyConnected>(banks_->feature_count(), layers_of(options),
                                                               options.paper.dropout))) {}

torch::Tensor RegressionNetwork::forward(const torch::Tensor& patches) {
  return layers_->forward(banks_->forward(patches));
}

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
