// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/batch_norm.h"

#include <cmath>
#include <span>

namespace knuckle {

FoldedNorm folded_norm(const WeightArrays& weights, const std::string& name) {
  FoldedNorm norm{weights.floats(name + ".weight"), weights.floats(name + ".bias")};
  const std::span<const float> means = weights.singles(name + ".running_mean");
  const std::span<const float> variances = weights.singles(name + ".running_var");
  for (std::size_t i = 0; i < norm.scales.size(); ++i) {
    norm.scales[i] /= std::sqrt(variances[i] + kNormEpsilon);
    norm.shifts[i] -= means[i] * norm.scales[i];
  }
  return norm;
}

}  // namespace knuckle
