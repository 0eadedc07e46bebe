// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/rotation_between.h"

namespace knuckle {

// Here alone: Eigen's function brings a whole decomposition, for directions that are opposite, into each
// file.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

}  // namespace knuckle
