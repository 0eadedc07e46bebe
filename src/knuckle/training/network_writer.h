// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <filesystem>

#include "knuckle/net/network_weights.h"
#include "knuckle/training/network_module.h"

namespace knuckle {

/// The numbers of a network, as they are stored: weights in half precision.
NetworkWeights weights_of(const NetworkOptions& options, const NetworkModule& network);

/// The other way: sets all that is stored. The network is that of the weights' options.
void set_weights(NetworkModule& network, const NetworkWeights& weights);

/// Writes a network for inference (net/network_file.h).
void save_network(const std::filesystem::path& path, const NetworkOptions& options,
                  const NetworkModule& network);

}  // namespace knuckle
