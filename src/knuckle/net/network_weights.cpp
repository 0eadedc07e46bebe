// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_weights.h"

#include <utility>

#include "knuckle/net/network_architectures.h"

namespace knuckle {

std::vector<NetworkArray> network_arrays(const NetworkOptions& options) {
  return architecture_of(options).arrays(options);
}

NetworkWeights::NetworkWeights(NetworkOptions options)
    : WeightArrays(network_arrays(options)), options_(std::move(options)) {}

NetworkWeights random_weights(const NetworkOptions& options, std::uint64_t seed) {
  check(options, "network");
  NetworkWeights weights(options);
  weights.fill_randomly(seed);
  return weights;
}

}  // namespace knuckle
