// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "knuckle/net/network_options.h"

namespace knuckle {

/// What an experiment has to know of a configuration of `knuckle train network`. The program that trains
/// reads the rest, for which LibTorch is needed.
struct NetworkConfig {
  std::string source;
  std::string validation;
  NetworkOptions network;

  /// Throws an Error that names file, line and key where one of these is wrong.
  static NetworkConfig load(const std::filesystem::path& path);
};

}  // namespace knuckle
