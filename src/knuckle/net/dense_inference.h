// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include "knuckle/net/layers/encoder_decoder.h"
#include "knuckle/net/layers/workspace_pool.h"
#include "knuckle/net/network_inference.h"

namespace knuckle {

/// The architecture `dense` (docs/networks.md).
class DenseInference final : public NetworkInference {
 public:
  explicit DenseInference(const NetworkWeights& weights);
  NetworkPrediction predict(const Image<float>& patch) const override;

 private:
  NetworkOptions options_;
  EncoderDecoder network_;
  WorkspacePool<EncoderDecoder::Maps> pool_;
};

}  // namespace knuckle
