// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <vector>

#include "knuckle/net/bank_features.h"
#include "knuckle/net/fully_connected_layer.h"
#include "knuckle/net/network_inference.h"

namespace knuckle {

/// The paper's five networks (Riegler et al. 2015, section 3): banks of convolutions, fully connected layers,
/// and an output of heat maps, or of u, v and d of each joint.
class PaperInference final : public NetworkInference {
 public:
  explicit PaperInference(const NetworkWeights& weights);
  NetworkPrediction predict(const Image<float>& patch) const override;

 private:
  NetworkOptions options_;
  BankFeatures banks_;
  std::vector<FullyConnectedLayer> layers_;
};

}  // namespace knuckle
