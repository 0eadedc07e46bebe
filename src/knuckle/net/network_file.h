// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "knuckle/net/network_weights.h"

namespace knuckle {

// A network's file is a LibTorch archive, but is read without LibTorch: such an archive is a zip in which the
// bytes of each tensor are a record NAME/data/N as they are. It holds two or three tensors, in this order:
// the header, a text as bytes; the weights, all arrays of half precision one after another; and the
// statistics of batch norms in single precision, where there are any.

/// What a network's file says it is.
inline constexpr std::string_view kNetworkFormat = "knuckle-network";
/// The version that is written and read.
inline constexpr int kNetworkVersion = 2;

/// The header: format, version, a line "PRECISION NAME SHAPE" for each array, "options", and those as TOML.
std::string network_header(const NetworkOptions& options);

/// Reads a network. Throws an Error that names the file where it is missing, cut short, damaged, foreign, of
/// another version, does not fit its own options, or holds a number that is not finite.
NetworkWeights load_network_weights(const std::filesystem::path& path);

}  // namespace knuckle
