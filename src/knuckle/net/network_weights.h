// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "knuckle/net/layers/weight_arrays.h"
#include "knuckle/net/network_options.h"

namespace knuckle {

/// All arrays of an architecture, in the order in which they are stored.
std::vector<NetworkArray> network_arrays(const NetworkOptions& options);

/// A network that infers poses, and all its numbers.
class NetworkWeights : public WeightArrays {
 public:
  /// All zero.
  explicit NetworkWeights(NetworkOptions options);

  const NetworkOptions& options() const { return options_; }

 private:
  NetworkOptions options_;
};

/// Weights of a network that has learned nothing (`WeightArrays::fill_randomly`). Throws an Error where an
/// option is out of range.
NetworkWeights random_weights(const NetworkOptions& options, std::uint64_t seed);

}  // namespace knuckle
