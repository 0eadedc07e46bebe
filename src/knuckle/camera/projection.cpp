// SPDX-License-Identifier: Apache-2.0
#include "knuckle/camera/projection.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// A point of the plane z = 1.
struct PlanePoint {
  double x;
  double y;
};

/// A distorted point, and how it moves with the undistorted one (row-major Jacobian).
struct Distorted {
  PlanePoint point;
  double dx_dx, dx_dy, dy_dx, dy_dy;
};

/// OpenCV's rational model: radial (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) and
/// tangential p1, p2.
Distorted distort(const std::array<double, 8>& coefficients, PlanePoint p) {
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = coefficients;
  const double r2 = p.x * p.x + p.y * p.y;
  const double numerator = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double denominator = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double numerator_slope = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
  const double denominator_slope = k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6);
  const double radial = numerator / denominator;
  const double radial_slope =
      (numerator_slope - radial * denominator_slope) / denominator;  // d radial / d r^2
  const double xy = p.x * p.y;
  Distorted result{};
  result.point.x = p.x * radial + 2.0 * p1 * xy + p2 * (r2 + 2.0 * p.x * p.x);
  result.point.y = p.y * radial + p1 * (r2 + 2.0 * p.y * p.y) + 2.0 * p2 * xy;
  result.dx_dx = radial + 2.0 * p.x * p.x * radial_slope + 2.0 * p1 * p.y + 6.0 * p2 * p.x;
  result.dx_dy = 2.0 * xy * radial_slope + 2.0 * p1 * p.x + 2.0 * p2 * p.y;
  result.dy_dx = 2.0 * xy * radial_slope + 2.0 * p1 * p.x + 2.0 * p2 * p.y;
  result.dy_dy = radial + 2.0 * p.y * p.y * radial_slope + 6.0 * p1 * p.y + 2.0 * p2 * p.x;
  return result;
}

/// Newton's method on `distort`; the start is the distorted point itself. Strong distortion far outside the
/// image may have no inverse: the last iterate comes back then.
PlanePoint undistort(const std::array<double, 8>& coefficients, PlanePoint target) {
  constexpr int kMaxIterations = 50;
  constexpr double kTolerance = 1e-15;
  PlanePoint p = target;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Distorted at = distort(coefficients, p);
    const double error_x = at.point.x - target.x;
    const double error_y = at.point.y - target.y;
    const double determinant = at.dx_dx * at.dy_dy - at.dx_dy * at.dy_dx;
    if (determinant == 0.0) break;
    const double step_x = (at.dy_dy * error_x - at.dx_dy * error_y) / determinant;
    const double step_y = (at.dx_dx * error_y - at.dy_dx * error_x) / determinant;
    p.x -= step_x;
    p.y -= step_y;
    if (std::abs(step_x) + std::abs(step_y) <= kTolerance * (1.0 + std::abs(p.x) + std::abs(p.y))) break;
  }
  return p;
}

}  // namespace

Projection::Projection(const Camera& camera) : camera_(camera), is_distorted_(camera.is_distorted()) {
  check(camera);
}

Point3 Projection::to_camera(const ImagePoint& point) const {
  PlanePoint plane{(point.u - camera_.cx) / camera_.fx, (point.v - camera_.cy) / camera_.fy};
  if (camera_.model == CameraModel::orthographic) return {plane.x, plane.y, point.depth_mm};
  if (is_distorted_) plane = undistort(camera_.distortion, plane);
  return {plane.x * point.depth_mm, plane.y * point.depth_mm, point.depth_mm};
}

ImagePoint Projection::to_image(const Point3& point) const {
  PlanePoint plane{point.x(), point.y()};
  if (camera_.model == CameraModel::projective) {
    if (!(point.z() > 0.0)) return {};
    plane = {point.x() / point.z(), point.y() / point.z()};
    if (is_distorted_) plane = distort(camera_.distortion, plane).point;
  }
  return {camera_.fx * plane.x + camera_.cx, camera_.fy * plane.y + camera_.cy, point.z()};
}

std::vector<Point3> Projection::to_camera(const std::vector<ImagePoint>& points) const {
  std::vector<Point3> result(points.size());
  std::ranges::transform(points, result.begin(),
                         [this](const ImagePoint& point) { return to_camera(point); });
  return result;
}

std::vector<ImagePoint> Projection::to_image(const std::vector<Point3>& points) const {
  std::vector<ImagePoint> result(points.size());
  std::ranges::transform(points, result.begin(), [this](const Point3& point) { return to_image(point); });
  return result;
}

double Projection::pixels_per_mm(double depth_mm) const {
  const double focal_length = std::abs(camera_.fx);
  return camera_.model == CameraModel::orthographic ? focal_length : focal_length / depth_mm;
}

RayTable::RayTable(const Camera& camera)
    : camera_(camera),
      is_orthographic_(camera.model == CameraModel::orthographic),
      rays_x_(camera.width, camera.height),
      rays_y_(camera.width, camera.height) {
  const Projection projection(camera);
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const Point3 ray = projection.to_camera(ImagePoint{double(column), double(row), 1.0});
      rays_x_(column, row) = static_cast<float>(ray.x());
      rays_y_(column, row) = static_cast<float>(ray.y());
    }
  }
}

}  // namespace knuckle
