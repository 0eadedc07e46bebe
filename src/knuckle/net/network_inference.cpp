// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_inference.h"

#include "knuckle/net/dense_inference.h"
#include "knuckle/net/paper_inference.h"

namespace knuckle {

std::unique_ptr<NetworkInference> create_inference(const NetworkWeights& weights) {
  if (weights.options().architecture == "dense") return std::make_unique<DenseInference>(weights);
  return std::make_unique<PaperInference>(weights);
}

}  // namespace knuckle
