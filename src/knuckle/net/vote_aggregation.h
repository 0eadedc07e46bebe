// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include "knuckle/core/image.h"
#include "knuckle/net/layers/feature_map.h"
#include "knuckle/net/network_inference.h"

namespace knuckle {

/// Adaptive weighting regression (Huang et al. 2020): each joint is the mean of the votes of all cells that
/// are hand (of all cells where none is), under the softmax of their weights.
///
/// `votes`: a cell a quarter of the patch's resolution; channels are offset u (of all joints), v, d,
/// closeness, weight, and in networks that tell sides one more, whose mean over these cells is the logit of a
/// right hand. `kernel`: the distance of the closeness 0.
NetworkPrediction aggregate_votes(const FeatureMap& votes, const Image<float>& patch, int joint_count,
                                  double kernel);

}  // namespace knuckle
