// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/render/point_projector.h"

#include <algorithm>
#include <cmath>

namespace knuckle {
namespace {

/// Corners farther from the image than this do not fit the integers [px]. Only what all but touches the
/// camera is.
constexpr double kGuardBand = 1 << 17;

std::int32_t subpixels(double pixels) {
  return static_cast<std::int32_t>(
      std::floor(std::clamp(pixels, -kGuardBand, kGuardBand) * kSubpixels + 0.5));
}

}  // namespace

PointProjector::PointProjector(const Camera& camera, double near_mm)
    : projection_(camera), camera_(camera), near_mm_(near_mm), is_distorted_(camera.is_distorted()) {
  if (is_distorted_) widest_ray_ = 1.2 * widest_ray_of_border();
}

template <class Scale>
void PointProjector::project_straight(std::span<const Eigen::Vector3f> points, ProjectedPoints& projected,
                                      const Scale& scale_at) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double scale = scale_at(points[i].z());
    projected.u[i] = camera_.fx * points[i].x() * scale + camera_.cx;
    projected.v[i] = camera_.fy * points[i].y() * scale + camera_.cy;
  }
}

void PointProjector::project_distorted(std::span<const Eigen::Vector3f> points,
                                       ProjectedPoints& projected) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d point = points[i].cast<double>();
    const bool is_trusted = point.z() >= near_mm_ && point.head<2>().norm() <= widest_ray_ * point.z();
    const ImagePoint image_point =
        is_trusted ? projection_.to_image(point) : ImagePoint{kGuardBand, kGuardBand, 0.0};
    projected.u[i] = image_point.u;
    projected.v[i] = image_point.v;
  }
}

double PointProjector::widest_ray_of_border() const {
  double widest = 0.0;
  const auto widen = [&](double u, double v) {
    widest = std::max(widest, projection_.to_camera(ImagePoint{u, v, 1.0}).head<2>().norm());
  };
  for (int column = 0; column < camera_.width; ++column) {
    widen(column, 0);
    widen(column, camera_.height - 1);
  }
  for (int row = 0; row < camera_.height; ++row) {
    widen(0, row);
    widen(camera_.width - 1, row);
  }
  return widest;
}

ProjectedPoints PointProjector::operator()(std::span<const Eigen::Vector3f> points) const {
  ProjectedPoints projected(points.size());
  if (is_distorted_) {
    project_distorted(points, projected);
  } else if (is_projective(camera_)) {
    project_straight(points, projected, [](double z) { return 1.0 / z; });
  } else {
    project_straight(points, projected, [](double) { return 1.0; });
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double z = points[i].z();
    projected.key[i] = is_projective(camera_) ? 1.0 / z : -z;
    const bool is_drawable =
        z >= near_mm_ && std::abs(projected.u[i]) < kGuardBand && std::abs(projected.v[i]) < kGuardBand;
    if (is_drawable) projected.places[i] = {subpixels(projected.u[i]), subpixels(projected.v[i])};
  }
  return projected;
}

}  // namespace knuckle
