// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "knuckle/net/network_weights.h"

namespace knuckle {

class ModelFile;

// A network's file is a model's (storage/model_file.h): the value `options`, its options as TOML; the array
// `weights`, all arrays of half precision one after another, as bits; and `norms`, the statistics of batch
// norms in single precision, where there are any.

/// What a network's file says it is.
inline constexpr std::string_view kNetworkFormat = "knuckle-network";
/// The version that is written and read.
inline constexpr int kNetworkVersion = 3;

/// Writes a network, atomically: the same network makes the same bytes. Throws an Error that names the file
/// where it cannot be written.
void save_network_weights(const std::filesystem::path& path, const NetworkWeights& weights);

/// Reads a network. Throws an Error that names the file where it is missing, cut short, damaged, foreign, of
/// another version, does not fit its own options, or holds a number that is not finite.
NetworkWeights load_network_weights(const std::filesystem::path& path);
/// The same of a file that is open.
NetworkWeights read_network_weights(const ModelFile& file);

}  // namespace knuckle
