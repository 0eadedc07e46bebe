// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "knuckle/core/image.h"
#include "knuckle/net/network_weights.h"
#include "knuckle/patch/hand_patch.h"

namespace knuckle {

/// What a network says about one patch.
struct NetworkPrediction {
  std::vector<PatchPoint> joints;         ///< one per landmark of the convention
  std::vector<float> confidence;          ///< one per joint, in [0, 1]; or empty where the network gives none
  std::optional<double> right_hand = {};  ///< how likely it is a right one, [0, 1]; nothing: it cannot tell
  std::optional<double> hand = {};        ///< how likely there is a hand at all; nothing: it cannot tell
};

/// A network, laid out for answering one patch at a time on the calling thread.
class NetworkInference {
 public:
  virtual ~NetworkInference() = default;
  /// `patch`: size_px x size_px, finite. Safe to call from many threads.
  virtual NetworkPrediction predict(const Image<float>& patch) const = 0;
};

/// The inference of the architecture that the weights are of.
std::unique_ptr<NetworkInference> create_inference(const NetworkWeights& weights);

}  // namespace knuckle
