// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_file.h"

#include <utility>

namespace knuckle {

void save_network_weights(const std::filesystem::path& path, const NetworkWeights& weights) {
  save_weights(path, kNetworkFormat, network_options_as_toml(weights.options()), weights);
}

NetworkWeights load_network_weights(const std::filesystem::path& path) {
  return read_network_weights(ModelFile::open(path));
}

NetworkWeights read_network_weights(ModelFile model) {
  const WeightFile file(std::move(model), kNetworkFormat);
  const NetworkOptions options = network_options_from_toml(file.options_toml(), file.origin());
  file.require(network_arrays(options));
  NetworkWeights weights(options);
  file.read(weights);
  return weights;
}

}  // namespace knuckle
