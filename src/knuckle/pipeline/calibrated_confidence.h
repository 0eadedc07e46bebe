// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace knuckle {

/// A confidence in [0, 1] as the share of joints with it that lie within 20 mm: its logit times `slope`, (0,
/// inf), plus `offset` (Platt 1999). 0 stays 0, and 1 stays 1.
inline double calibrated_confidence(double confidence, double offset, double slope) {
  if (!(confidence > 0.0) || confidence >= 1.0) return confidence;
  return 1.0 / (1.0 + std::exp(-offset) * std::pow((1.0 - confidence) / confidence, slope));
}

}  // namespace knuckle
