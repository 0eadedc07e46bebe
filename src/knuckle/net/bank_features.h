// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <vector>

#include "knuckle/core/image.h"
#include "knuckle/net/layers/convolution.h"
#include "knuckle/net/layers/workspace_pool.h"
#include "knuckle/net/network_weights.h"
#include "knuckle/net/paper_architecture.h"

namespace knuckle {

/// The multi-resolution features of Tompson et al. 2014, as the paper uses them: three banks of two
/// convolutions, each with a ReLU and a max-pooling, on the patch, a half and a quarter of it.
class BankFeatures {
 public:
  explicit BankFeatures(const NetworkWeights& weights);
  /// Bank by bank, in each map by map, row by row.
  std::vector<float> features_of(const Image<float>& patch) const;

 private:
  struct LayerMaps {
    FeatureMap convolved, pooled;
  };
  struct BankMaps {
    FeatureMap input;
    std::vector<LayerMaps> layers;
  };
  using Maps = std::vector<BankMaps>;
  struct Layer {
    Convolution convolution;
    int pool;
  };

  Maps make_maps() const;

  int patch_size_;
  std::vector<std::vector<Layer>> banks_;
  WorkspacePool<Maps> pool_;
};

}  // namespace knuckle
