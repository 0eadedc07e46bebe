// SPDX-License-Identifier: Apache-2.0
// Private to the module: random numbers as scenes use them.
#pragma once

#include <Eigen/Core>

#include "knuckle/core/random.h"

namespace knuckle {

/// Uniform in [low, high), in single precision.
inline float between(Random& random, double low, double high) {
  return static_cast<float>(random.uniform(low, high));
}

/// Three independent normal numbers.
inline Eigen::Vector3f normal_vector(Random& random) {
  const double x = random.normal();
  const double y = random.normal();
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(random.normal())};
}

}  // namespace knuckle
