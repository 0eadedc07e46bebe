// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace knuckle {

/// The smallest rotation that turns the direction `from` into `to`; neither has to be of length 1.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// The right-handed turn by `angle` [rad] about `axis`, which has length 1. Unlike Eigen::AngleAxis it has
/// the same bits on every processor.
Eigen::Quaterniond rotation_about(double angle, const Eigen::Vector3d& axis);

}  // namespace knuckle
