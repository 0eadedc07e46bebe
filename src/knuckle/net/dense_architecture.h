// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "knuckle/net/network_weights.h"

namespace knuckle {

inline constexpr int kDenseStages = 3;   ///< at a quarter, an eighth and a sixteenth of the patch
inline constexpr int kDenseStride = 4;   ///< patch pixels a cell of the maps of votes
inline constexpr int kMapsPerJoint = 5;  ///< offset u, v, d; closeness; weight
/// Spread of the votes at which the confidence falls to 1 / e: 19 mm in a cube of 250 mm.
inline constexpr double kSpreadScale = 0.15;

/// A convolution (padded to keep the size, without bias) with its batch norm.
struct DenseUnit {
  std::string name;
  int inputs;
  int outputs;
  int kernel;
  int stride;
};

/// All units of the architecture `dense` but the head, which has a bias and no norm.
std::vector<DenseUnit> dense_units(const DenseNetworkOptions& options);

/// Its arrays, as `network_arrays` has them.
std::vector<NetworkArray> dense_arrays(const NetworkOptions& options);

}  // namespace knuckle
