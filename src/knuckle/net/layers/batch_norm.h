// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "knuckle/net/layers/weight_arrays.h"

namespace knuckle {

inline constexpr float kNormEpsilon = 1e-5f;  ///< added to the variances of batch norms

/// A batch norm in use: outputs = scales * inputs + shifts, one of each a channel. In double, so that what
/// they are multiplied into is rounded once: the same background lies behind most pixels, and its rounding
/// errors do not cancel in the sums of later layers.
struct FoldedNorm {
  std::vector<double> scales;
  std::vector<double> shifts;
};

/// The batch norm `name` of a network (Ioffe and Szegedy 2015), with the statistics that training measured.
FoldedNorm folded_norm(const WeightArrays& weights, const std::string& name);

/// Scales or shifts in single precision.
std::vector<float> singles_of(const std::vector<double>& numbers);

}  // namespace knuckle
