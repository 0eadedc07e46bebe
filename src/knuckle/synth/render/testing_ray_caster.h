// SPDX-License-Identifier: Apache-2.0
// For tests only: the slow and obvious way to see a mesh.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "knuckle/camera/projection.h"
#include "knuckle/synth/render/rasteriser.h"

namespace knuckle::testing {

/// What the ray through (u, v) meets first: the distance along z, or infinity, and the face.
struct RayHit {
  double depth_mm = std::numeric_limits<double>::infinity();
  std::int32_t face = Rendering::kNoFace;
};

/// Tries every triangle (Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997).
inline RayHit cast_ray(const TriangleMesh& mesh, const Projection& projection, double u, double v,
                       double near_mm) {
  const Eigen::Vector3d one = projection.to_camera(ImagePoint{u, v, 1.0});
  const bool projective = projection.camera().model == CameraModel::projective;
  const Eigen::Vector3d origin =
      projective ? Eigen::Vector3d::Zero() : Eigen::Vector3d(one.x(), one.y(), 0.0);
  const Eigen::Vector3d direction = one - origin;  // its z is 1: the ray's parameter is the depth
  RayHit nearest;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3d a = mesh.vertices[mesh.faces[f][0]].cast<double>();
    const Eigen::Vector3d ab = mesh.vertices[mesh.faces[f][1]].cast<double>() - a;
    const Eigen::Vector3d ac = mesh.vertices[mesh.faces[f][2]].cast<double>() - a;
    const Eigen::Vector3d p = direction.cross(ac);
    const double determinant = ab.dot(p);
    if (determinant == 0.0) continue;
    const Eigen::Vector3d from_a = origin - a;
    const double s = from_a.dot(p) / determinant;
    const Eigen::Vector3d q = from_a.cross(ab);
    const double t = direction.dot(q) / determinant;
    if (s < 0.0 || t < 0.0 || s + t > 1.0) continue;
    const double depth = ac.dot(q) / determinant;
    if (depth >= near_mm && depth < nearest.depth_mm) nearest = {depth, static_cast<std::int32_t>(f)};
  }
  return nearest;
}

}  // namespace knuckle::testing
