// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace knuckle {

/// A simple convex body: what contact with a thing is tested by.
struct Solid {
  enum class Kind : std::uint8_t {
    box,   ///< `size`: half its extents
    cone,  ///< a round frustum about z; `size`: radius at the bottom, radius at the top, half its height
    ball,  ///< `size`: its radius, three times
  };
  Kind kind = Kind::box;
  Eigen::Vector3f size = Eigen::Vector3f::Ones();                      ///< above 0 [mm]
  Eigen::Isometry3f thing_from_solid = Eigen::Isometry3f::Identity();  ///< where it lies in the thing [mm]

  /// How far a point of the thing is outside; negative: how deep inside [mm]. Its sign is exact. Beyond edges
  /// of boxes and cones the value is at most the true distance.
  float distance_mm(const Eigen::Vector3f& point) const;
};

/// The least of the distances: to a thing that is made of several solids. Infinite where there is none.
float distance_mm(std::span<const Solid> solids, const Eigen::Vector3f& point);

}  // namespace knuckle
