// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace knuckle {

/// The likelihood whose logarithm of the odds this is: (0, 1).
inline double logistic(double log_odds) {
  return 1.0 / (1.0 + std::exp(-log_odds));
}

/// The logarithm of a likelihood's odds, [0, 1]. What is nearer to 0 or 1 than a thousandth counts as that:
/// nobody is surer.
inline double log_odds(double likelihood) {
  constexpr double kLeast = 1e-3;
  const double bounded = std::clamp(likelihood, kLeast, 1.0 - kLeast);
  return std::log(bounded / (1.0 - bounded));
}

}  // namespace knuckle
