// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <array>
#include <vector>

#include "knuckle/net/convolution.h"
#include "knuckle/net/dense_architecture.h"
#include "knuckle/net/network_inference.h"
#include "knuckle/net/workspace_pool.h"

namespace knuckle {

/// The architecture `dense` (docs/networks.md), its batch norms folded into the convolutions before them.
class DenseInference final : public NetworkInference {
 public:
  explicit DenseInference(const NetworkWeights& weights);
  NetworkPrediction predict(const Image<float>& patch) const override;

 private:
  /// All maps of one look.
  struct Maps {
    explicit Maps(const NetworkOptions& options);
    FeatureMap patch, stem;
    std::vector<FeatureMap> stages;  // features at a quarter, an eighth, a sixteenth
    std::vector<FeatureMap> inner;   // of the same sizes: inside of residual blocks
    FeatureMap lateral2, smooth2, lateral1, smooth1, votes;
  };
  struct Block {
    Convolution first, second;
  };
  struct Stage {
    Convolution down;
    std::vector<Block> blocks;
  };

  void encode(Maps& maps) const;
  void decode(Maps& maps) const;

  NetworkOptions options_;
  Convolution stem_;
  std::vector<Stage> stages_;
  Convolution lateral2_, smooth2_, lateral1_, smooth1_, head_;
  WorkspacePool<Maps> pool_;
};

}  // namespace knuckle
