// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_inference.h"

#include "knuckle/net/network_architectures.h"

namespace knuckle {

std::unique_ptr<NetworkInference> create_inference(const NetworkWeights& weights) {
  return architecture_of(weights.options()).create_inference(weights);
}

}  // namespace knuckle
