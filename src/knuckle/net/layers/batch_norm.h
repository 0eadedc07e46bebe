// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "knuckle/net/layers/weight_arrays.h"

namespace knuckle {

inline constexpr float kNormEpsilon = 1e-5f;  ///< added to the variances of batch norms

/// A batch norm in use: outputs = scales * inputs + shifts, one of each a channel.
struct FoldedNorm {
  std::vector<float> scales;
  std::vector<float> shifts;
};

/// The batch norm `name` of a network (Ioffe and Szegedy 2015), with the statistics that training measured.
FoldedNorm folded_norm(const WeightArrays& weights, const std::string& name);

}  // namespace knuckle
