// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "knuckle/core/camera.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// What a scene is built around, in camera coordinates [mm].
struct SceneActors {
  Camera camera;
  std::array<Point3, kSupersetSize> landmarks;  ///< of the hand
  Point3 elbow;
  Eigen::Vector3f up;                   ///< against gravity, of length 1
  std::vector<Eigen::Vector3f> points;  ///< of all skin that is there: nothing may run into them
  std::size_t hand_points = 0;          ///< the first of these are the hand's

  const Point3& palm() const { return landmarks[static_cast<std::size_t>(Landmark::palm)]; }
};

}  // namespace knuckle
