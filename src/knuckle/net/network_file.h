// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/net/layers/weight_file.h"
#include "knuckle/net/network_weights.h"

namespace knuckle {

/// What the file of a network that infers poses says it is, and the version that is written and read.
inline constexpr WeightFormat kNetworkFormat{"knuckle-network", 3};

/// Writes a network, atomically: the same network makes the same bytes. Throws an Error that names the file
/// where it cannot be written.
void save_network_weights(const std::filesystem::path& path, const NetworkWeights& weights);

/// Reads a network. Throws an Error that names the file where it is missing, cut short, damaged, foreign, of
/// another version, does not fit its own options, or holds a number that is not finite.
NetworkWeights load_network_weights(const std::filesystem::path& path);
/// The same of a file that is open.
NetworkWeights read_network_weights(ModelFile model);

}  // namespace knuckle
