// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/pose_network.h"

#include <cmath>

#include "knuckle/core/error.h"
#include "knuckle/net/network_file.h"

namespace knuckle {

PoseNetwork::PoseNetwork(const std::filesystem::path& path) : PoseNetwork(load_network_weights(path)) {}

PoseNetwork::PoseNetwork(const NetworkOptions& options, std::uint64_t seed)
    : PoseNetwork(random_weights(options, seed)) {}

PoseNetwork::PoseNetwork(const NetworkWeights& weights)
    : options_(weights.options()), inference_(create_inference(weights)) {}

NetworkPrediction PoseNetwork::predict(const Image<float>& patch) const {
  const int size = options_.patch.size_px;
  if (patch.width() != size || patch.height() != size) {
    fail("network: a patch of {} x {}, expected {} x {}", patch.width(), patch.height(), size, size);
  }
  for (const float pixel : patch.pixels()) {
    if (!std::isfinite(pixel)) fail("network: a pixel of the patch is not finite");
  }
  NetworkPrediction prediction = inference_->predict(patch);
  for (const PatchPoint& joint : prediction.joints) {
    if (!std::isfinite(joint.u + joint.v + joint.d)) fail("network: a joint it predicts is not finite");
  }
  return prediction;
}

}  // namespace knuckle
