// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/batch_norm.h"

#include <cmath>
#include <span>

namespace knuckle {

FoldedNorm folded_norm(const WeightArrays& weights, const std::string& name) {
  const std::vector<float> factors = weights.floats(name + ".weight");
  const std::vector<float> biases = weights.floats(name + ".bias");
  const std::span<const float> means = weights.singles(name + ".running_mean");
  const std::span<const float> variances = weights.singles(name + ".running_var");
  FoldedNorm norm;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const double scale = factors[i] / std::sqrt(double{variances[i]} + kNormEpsilon);
    norm.scales.push_back(scale);
    norm.shifts.push_back(biases[i] - means[i] * scale);
  }
  return norm;
}

std::vector<float> singles_of(const std::vector<double>& numbers) {
  std::vector<float> singles;
  for (const double number : numbers) singles.push_back(static_cast<float>(number));
  return singles;
}

}  // namespace knuckle
