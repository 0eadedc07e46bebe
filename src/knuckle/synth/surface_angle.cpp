// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/surface_angle.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "knuckle/camera/projection.h"

namespace knuckle {
namespace {

/// A face's plane n p = h with n of length 1.
struct FacePlane {
  float distance = 0.0f;  ///< |h|: of the plane from the camera [mm]
  float facing = 0.0f;    ///< |n_z|
};

FacePlane plane_of(const TriangleMesh& mesh, std::int32_t face) {
  const auto [a, b, c] = mesh.faces[face];
  const Eigen::Vector3f& corner = mesh.vertices[a];
  const Eigen::Vector3f normal = (mesh.vertices[b] - corner).cross(mesh.vertices[c] - corner);
  const float length = normal.norm();
  if (!(length > 0.0f)) return {};
  return {std::abs(normal.dot(corner)) / length, std::abs(normal.z()) / length};
}

float square_of_ray(int pixel, double centre, double focal_length) {
  const double x = (pixel - centre) / focal_length;
  return static_cast<float>(x * x);
}

}  // namespace

RayLengths::RayLengths(const Camera& camera) : is_distorted_(camera.is_distorted()) {
  if (is_distorted_) {
    const RayTable rays(camera);
    lengths_ = Image<float>(camera.width, camera.height);
    for (std::size_t i = 0; i < lengths_.size(); ++i) {
      const float x = rays.rays_x().data()[i];
      const float y = rays.rays_y().data()[i];
      lengths_.data()[i] = std::sqrt(1.0f + x * x + y * y);
    }
    return;
  }
  x2_.resize(camera.width, 0.0f);
  y2_.resize(camera.height, 0.0f);
  if (camera.model == CameraModel::orthographic) return;
  for (int i = 0; i < camera.width; ++i) x2_[i] = square_of_ray(i, camera.cx, camera.fx);
  for (int i = 0; i < camera.height; ++i) y2_[i] = square_of_ray(i, camera.cy, camera.fy);
}

float RayLengths::operator()(int column, int row) const {
  return is_distorted_ ? lengths_(column, row) : std::sqrt(1.0f + x2_[column] + y2_[row]);
}

Image<float> surface_cosines(const Rendering& rendering, const TriangleMesh& mesh, const Camera& camera) {
  Image<float> cosines(camera.width, camera.height);
  const bool is_orthographic = camera.model == CameraModel::orthographic;
  const RayLengths ray_length(camera);
  std::int32_t last_face = Rendering::kNoFace;
  FacePlane plane;
  for (int row = 0; row < camera.height; ++row) {
    const std::int32_t* faces = rendering.face.row(row).data();
    const float* depths = rendering.depth_mm.row(row).data();
    float* result = cosines.row(row).data();
    for (int column = 0; column < camera.width; ++column) {
      if (faces[column] == Rendering::kNoFace) continue;
      if (faces[column] != last_face) plane = plane_of(mesh, faces[column]);
      last_face = faces[column];
      const float cosine =
          is_orthographic ? plane.facing : plane.distance / (depths[column] * ray_length(column, row));
      result[column] = std::min(cosine, 1.0f);
    }
  }
  return cosines;
}

}  // namespace knuckle
