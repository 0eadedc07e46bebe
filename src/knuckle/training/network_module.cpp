// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_module.h"

#include <array>
#include <string_view>

#include <torch/utils.h>

#include "knuckle/core/named_table.h"
#include "knuckle/training/dense_network.h"
#include "knuckle/training/heat_map_network.h"
#include "knuckle/training/regression_network.h"

namespace knuckle {
namespace {

template <class Network>
std::shared_ptr<NetworkModule> make_module(const NetworkOptions& options) {
  return std::make_shared<Network>(options);
}

struct TrainedArchitecture {
  std::string_view name;
  std::shared_ptr<NetworkModule> (*make)(const NetworkOptions& options);
};

constexpr std::array kArchitectures{
    TrainedArchitecture{"dense", make_module<DenseNetwork>},
    TrainedArchitecture{"heatmap2d", make_module<HeatMapNetwork>},
    TrainedArchitecture{"heatmap25d", make_module<HeatMapNetwork>},
    TrainedArchitecture{"regression", make_module<RegressionNetwork>},
    TrainedArchitecture{"pca", make_module<RegressionNetwork>},
    TrainedArchitecture{"autoencoder", make_module<RegressionNetwork>},
};

}  // namespace

std::shared_ptr<NetworkModule> make_network(const NetworkOptions& options, std::uint64_t seed) {
  check(options, "network");
  torch::manual_seed(seed);  // weights are drawn from LibTorch's own generator
  std::shared_ptr<NetworkModule> network = row_named(kArchitectures, options.architecture)->make(options);
  lay_out_for_channels_last(*network);
  return network;
}

}  // namespace knuckle
