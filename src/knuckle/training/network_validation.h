// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <torch/types.h>

#include "knuckle/prepare/cube_samples.h"
#include "knuckle/training/network_module.h"
#include "knuckle/training/network_training.h"

namespace knuckle {

/// The PoseScores of a network (in evaluation) over samples that are seen as they were cut out, and again
/// around the mean of the joints found first.
std::vector<double> validation_errors(NetworkModule& network, const CubeSamples& samples,
                                      const torch::Device& device);

}  // namespace knuckle
