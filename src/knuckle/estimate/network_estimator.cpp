// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/network_estimator.h"

#include <utility>

namespace knuckle {

double sure_confidence_of(const NetworkOptions& network) {
  return network.architecture == "dense" ? 0.45 : 0.0;
}

NetworkEstimator::NetworkEstimator(PoseNetwork network, const NetworkEstimatorOptions& options)
    : network_(std::move(network)),
      options_(options),
      convention_(network_.options().landmarks()),
      patches_(network_.options().patch) {
  check_options(options_, "network estimator");
}

PatchPose NetworkEstimator::estimate(const HandPatch& patch) const {
  NetworkPrediction prediction = network_.predict(patch.pixels);
  return {std::move(prediction.joints), std::move(prediction.confidence), prediction.right_hand,
          prediction.hand};
}

}  // namespace knuckle
