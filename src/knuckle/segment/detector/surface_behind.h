// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

#include "knuckle/camera/projection.h"
#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// A plane that a hand is seen before: a table, a wall, a chest.
struct SurfaceBehind {
  Eigen::Vector3f normal = Eigen::Vector3f(0, 0, -1);  ///< of length 1, towards the camera
  float offset_mm = 0.0f;                              ///< of its points p: normal.dot(p)
  float deviation_mm = 0.0f;  ///< of what was measured of it, robust (1.4826 times the median distance)

  /// How far a point (camera coordinates, mm) lies before it, towards the camera; below 0 behind it [mm].
  float height_mm(const Eigen::Vector3f& point) const { return normal.dot(point) - offset_mm; }

  /// What lies higher is not the surface: 3 deviations, but 6 mm at least and 15 mm, a finger, at most.
  float thickness_mm() const;
};

/// The plane that most of a ball's surroundings lie on: of what was measured farther than `radius_mm` from
/// `centre` (camera coordinates, mm), but within 1.6 times that. Some hundreds of points of a grid of pixels
/// are looked at. Of random planes through three of them the one with the most points nearby counts (RANSAC,
/// Fischler and Bolles 1981), fitted to these by least squares.
///
/// Nothing where less than half of what was measured around the ball lies on one plane, or where that is seen
/// in less than half of all directions: so a forearm is no surface, nor are the seat and the back of a chair.
/// The same image always has the same surface. `rays` has the size of the image. Safe to call from many
/// threads.
std::optional<SurfaceBehind> surface_behind(const Image<float>& depth_mm, const RayTable& rays,
                                            const Point3& centre, double radius_mm);

}  // namespace knuckle
