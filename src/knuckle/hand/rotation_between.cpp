// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/rotation_between.h"

#include "knuckle/core/portable_math.h"

namespace knuckle {

// Here alone: Eigen's function brings a whole decomposition, for directions that are opposite, into each
// file.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

Eigen::Quaterniond rotation_about(double angle, const Eigen::Vector3d& axis) {
  const double part = portable_sin(0.5 * angle);
  return {portable_cos(0.5 * angle), part * axis.x(), part * axis.y(), part * axis.z()};
}

}  // namespace knuckle
