// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include "knuckle/core/image.h"
#include "knuckle/net/dense_architecture.h"
#include "knuckle/net/layers/feature_map.h"
#include "knuckle/net/network_inference.h"

namespace knuckle {

/// Adaptive weighting regression (Huang et al. 2020): each joint is the mean of the votes of all cells that
/// are hand (of all cells where none is), under the softmax of their weights.
///
/// `votes`: a cell a quarter of the patch's resolution; channels are offset u (of all joints), v, d,
/// closeness, weight, then those that tell sides and hands, whose means over these cells are logits.
NetworkPrediction aggregate_votes(const FeatureMap& votes, const Image<float>& patch, int joint_count,
                                  const DenseMaps& maps, double kernel);

}  // namespace knuckle
