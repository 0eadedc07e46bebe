// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <torch/types.h>

#include "knuckle/training/batch_loader.h"
#include "knuckle/training/trainable_module.h"

namespace knuckle {

/// Measures the means and variances of all batch norms anew, over so many batches of a plan. Averaged weights
/// need it: the running statistics are those of the weights in training, whose activations differ (Izmailov
/// et al., "Averaging weights leads to wider optima and better generalization", 2018). Dropout sleeps
/// meanwhile, as it does in use. Leaves the network in evaluation.
void measure_norm_statistics(TrainableModule& network, BatchPlan plan, int batches,
                             const torch::Device& device);

}  // namespace knuckle
