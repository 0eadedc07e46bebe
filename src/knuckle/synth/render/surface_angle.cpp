// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/render/surface_angle.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "knuckle/camera/projection.h"
#include "knuckle/core/empty_blocks.h"

namespace knuckle {
namespace {

/// What a face adds to the cosine of its pixels: the distance of its plane from the camera (|h| of the plane
/// n p = h with n of length 1), or for parallel rays |n_z|.
float share_of_face(const TriangleMesh& mesh, std::int32_t face, CameraModel model) {
  const auto [a, b, c] = mesh.faces[face];
  const Eigen::Vector3f& corner = mesh.vertices[a];
  const Eigen::Vector3f normal = (mesh.vertices[b] - corner).cross(mesh.vertices[c] - corner);
  const float length = normal.norm();
  if (!(length > 0.0f)) return 0.0f;
  return std::abs(model == CameraModel::orthographic ? normal.z() : normal.dot(corner)) / length;
}

/// The same at each pixel; 0 where nothing is seen. A face is computed once, when it is first met.
Image<float> shares_of_faces(const Rendering& rendering, const TriangleMesh& mesh, CameraModel model) {
  constexpr float kNotMet = -1.0f;
  std::vector<float> share_of(mesh.faces.size(), kNotMet);
  Image<float> shares(rendering.face.width(), rendering.face.height());
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const std::int32_t face = rendering.face.data()[i];
    if (face == Rendering::kNoFace) continue;
    if (share_of[face] == kNotMet) share_of[face] = share_of_face(mesh, face, model);
    shares.data()[i] = share_of[face];
  }
  return shares;
}

float square_of_ray(int pixel, double centre, double focal_length) {
  const double x = (pixel - centre) / focal_length;
  return static_cast<float>(x * x);
}

}  // namespace

Image<float> squared_ray_lengths(const Camera& camera) {
  Image<float> squares(camera.width, camera.height, 1.0f);
  if (camera.model == CameraModel::orthographic) return squares;
  if (camera.is_distorted()) {
    const RayTable rays(camera);
    for (std::size_t i = 0; i < squares.size(); ++i) {
      const float x = rays.rays_x().data()[i];
      const float y = rays.rays_y().data()[i];
      squares.data()[i] = 1.0f + x * x + y * y;
    }
    return squares;
  }
  std::vector<float> x2(camera.width);
  for (int column = 0; column < camera.width; ++column) {
    x2[column] = square_of_ray(column, camera.cx, camera.fx);
  }
  for (int row = 0; row < camera.height; ++row) {
    const float y2 = 1.0f + square_of_ray(row, camera.cy, camera.fy);
    float* result = squares.row(row).data();
    for (int column = 0; column < camera.width; ++column) result[column] = y2 + x2[column];
  }
  return squares;
}

Image<float> surface_cosines(const Rendering& rendering, const TriangleMesh& mesh, const Camera& camera) {
  Image<float> cosines = shares_of_faces(rendering, mesh, camera.model);
  const Image<float> squares = squared_ray_lengths(camera);
  const bool is_orthographic = camera.model == CameraModel::orthographic;
  const float* depths = rendering.depth_mm.data();
  for_each_seen_block(depths, cosines.size(), [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      const float length =
          is_orthographic || depths[i] == 0.0f ? 1.0f : depths[i] * std::sqrt(squares.data()[i]);
      cosines.data()[i] = std::min(cosines.data()[i] / length, 1.0f);
    }
  });
  return cosines;
}

}  // namespace knuckle
