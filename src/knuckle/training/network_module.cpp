// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_module.h"

#include <torch/utils.h>

#include "knuckle/training/dense_network.h"
#include "knuckle/training/heat_map_network.h"
#include "knuckle/training/regression_network.h"

namespace knuckle {
namespace {

std::shared_ptr<NetworkModule> make_architecture(const NetworkOptions& options) {
  if (options.architecture == "dense") return std::make_shared<DenseNetwork>(options);
  if (options.architecture.starts_with("heatmap")) return std::make_shared<HeatMapNetwork>(options);
  return std::make_shared<RegressionNetwork>(options);
}

}  // namespace

std::shared_ptr<NetworkModule> make_network(const NetworkOptions& options, std::uint64_t seed) {
  check(options, "network");
  torch::manual_seed(seed);  // weights are drawn from LibTorch's own generator
  std::shared_ptr<NetworkModule> network = make_architecture(options);
  for (torch::Tensor& parameter : network->parameters()) {
    if (parameter.dim() == 4) {
      parameter.set_data(parameter.detach().contiguous(torch::MemoryFormat::ChannelsLast));
    }
  }
  return network;
}

}  // namespace knuckle
