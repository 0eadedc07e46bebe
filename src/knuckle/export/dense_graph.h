// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include "knuckle/net/network_weights.h"
#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle {

/// Adds the architecture `dense`, votes and all (net/vote_aggregation.h): from `patch` to `landmarks`,
/// `confidence` and, where the network tells them, `right_hand` and `hand`.
void add_dense_graph(OnnxModel& model, const NetworkWeights& weights);

}  // namespace knuckle
