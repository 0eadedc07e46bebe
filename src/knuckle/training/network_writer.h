// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <filesystem>
#include <string>

#include "knuckle/net/network_weights.h"
#include "knuckle/training/network_module.h"

namespace knuckle {

/// Copies all numbers that are stored of a network: weights in half precision.
void copy_weights(const TrainableModule& network, WeightArrays& weights);

/// The numbers of a network that infers poses.
NetworkWeights weights_of(const NetworkOptions& options, const NetworkModule& network);

/// The other way: sets all that is stored. The network is that of the weights' options, or has more maps:
/// those behind the known ones stay as they are.
void set_weights(TrainableModule& network, const WeightArrays& weights);

/// Writes a network for inference (net/network_file.h).
void save_network(const std::filesystem::path& path, const NetworkOptions& options,
                  const NetworkModule& network);

}  // namespace knuckle
