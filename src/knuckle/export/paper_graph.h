// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include "knuckle/net/network_weights.h"
#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle {

/// Adds one of the paper's five networks: from `patch` to `landmarks`, or to `heat_maps` (and `depth_bins`),
/// whose peaks are found by who reads them (net/heat_map.h): a fit of Gaussians around the largest cell is no
/// graph of operators.
void add_paper_graph(OnnxModel& model, const NetworkWeights& weights);

}  // namespace knuckle
