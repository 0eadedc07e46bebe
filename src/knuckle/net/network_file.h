// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <filesystem>
#include <memory>

#include "knuckle/net/network_module.h"

namespace knuckle {

/// Writes a network for inference as a LibTorch archive (format "knuckle-network", version 1) with its
/// options inside, its weights in half precision. It appears only when whole.
void save_network(const std::filesystem::path& path, const NetworkOptions& options,
                  const NetworkModule& network);

/// A network as its file holds it.
struct LoadedNetwork {
  NetworkOptions options;
  std::shared_ptr<NetworkModule> network;  ///< in single precision
};

/// Reads it back. Throws an Error that names the file where it is missing, cut short, foreign, of another
/// version, or does not fit its own options.
LoadedNetwork load_network(const std::filesystem::path& path);

}  // namespace knuckle
