// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_file.h"

namespace knuckle {

void save_network_weights(const std::filesystem::path& path, const NetworkWeights& weights) {
  save_weights(path, kNetworkFormat, network_options_as_toml(weights.options()), weights);
}

NetworkWeights load_network_weights(const std::filesystem::path& path) {
  const WeightFile file(path, kNetworkFormat);
  const NetworkOptions options = network_options_from_toml(file.options_toml(), file.origin());
  file.require(network_arrays(options));
  NetworkWeights weights(options);
  file.read(weights);
  return weights;
}

}  // namespace knuckle
