// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include "knuckle/pipeline/hand_finder.h"

namespace knuckle {

/// A confidence in [0, 1] as the share of joints with it that lie within 20 mm: its logit times `slope`, (0,
/// inf), plus `offset` (Platt 1999). 0 stays 0, and 1 stays 1.
inline double calibrated_confidence(double confidence, double offset, double slope) {
  if (!(confidence > 0.0) || confidence >= 1.0) return confidence;
  return 1.0 / (1.0 + std::exp(-offset) * std::pow((1.0 - confidence) / confidence, slope));
}

/// Calibrates the confidences of a hand's joints in place, as the options say.
inline void calibrate(std::vector<float>& confidences, const HandOptions& options) {
  if (options.confidence_offset == 0.0 && options.confidence_slope == 1.0) return;
  for (float& confidence : confidences) {
    confidence = static_cast<float>(
        calibrated_confidence(confidence, options.confidence_offset, options.confidence_slope));
  }
}

}  // namespace knuckle
