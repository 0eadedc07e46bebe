// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace knuckle {

/// A rotation and a shift, named by its frames: `camera_from_hand * point_in_hand` is a point in camera
/// coordinates; shifts are in mm. Unlike Eigen::Isometry3d it has the same layout under all compiler flags,
/// so that a program may be built for another processor than the library. Converts from and to
/// Eigen::Isometry3d.
using RigidTransform = Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;
static_assert(sizeof(RigidTransform) == 16 * sizeof(double) && alignof(RigidTransform) == alignof(double));

}  // namespace knuckle
