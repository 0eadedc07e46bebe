// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_module.h"

#include <torch/utils.h>

#include "knuckle/net/dense_network.h"

namespace knuckle {

std::shared_ptr<NetworkModule> make_network(const NetworkOptions& options, std::uint64_t seed) {
  check(options, "network");
  torch::manual_seed(seed);  // weights are drawn from LibTorch's own generator
  auto network = std::make_shared<DenseNetwork>(options);
  for (torch::Tensor& parameter : network->parameters()) {
    if (parameter.dim() == 4) {
      parameter.set_data(parameter.detach().contiguous(torch::MemoryFormat::ChannelsLast));
    }
  }
  return network;
}

}  // namespace knuckle
