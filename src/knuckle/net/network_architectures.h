// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "knuckle/net/network_inference.h"
#include "knuckle/net/network_options.h"
#include "knuckle/net/network_weights.h"

namespace knuckle {

/// All that inference has to know of an architecture.
struct NetworkArchitecture {
  std::string_view name;
  int smallest_patch_px;
  /// The options that it alone reads.
  void (*visit)(NetworkOptions& options, OptionVisitor& visitor);
  std::vector<NetworkArray> (*arrays)(const NetworkOptions& options);
  std::unique_ptr<NetworkInference> (*create_inference)(const NetworkWeights& weights);
};

/// The architecture that the options name. Throws an Error that lists the known ones.
const NetworkArchitecture& architecture_of(const NetworkOptions& options);

}  // namespace knuckle
