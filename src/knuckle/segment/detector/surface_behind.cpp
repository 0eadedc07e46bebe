// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/surface_behind.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "knuckle/core/frame.h"
#include "knuckle/core/random.h"

namespace knuckle {
namespace {

using Points = std::vector<Eigen::Vector3f>;

constexpr double kSurroundings = 1.6;  // how far around a ball its surface is looked for, in its radii
constexpr int kGridPoints = 50;        // across that
constexpr std::size_t kFewestPoints = 50;
constexpr int kTrials = 60;  // where half of all points lie on the plane, all fail once in 3,000 times
constexpr float kLeastShare = 0.5f;
constexpr int kDirections = 12;
constexpr int kFewestDirections = 6;

struct Plane {
  Eigen::Vector3f normal;
  float offset_mm;

  float distance_mm(const Eigen::Vector3f& point) const { return std::abs(normal.dot(point) - offset_mm); }
};

/// How far from its plane a measurement may lie: noise grows with the square of the distance.
float tolerance_mm(const Point3& centre) {
  const auto metres = static_cast<float>(centre.z() / 1000.0);
  return 10.0f * std::max(1.0f, metres * metres);
}

/// Every how many pixels, along rows and columns, the surroundings are looked at.
int grid_step(const Camera& camera, const Point3& centre, double radius_mm) {
  const double distance_mm = std::max(centre.z(), radius_mm);  // the ball may hold the camera
  const double pixels_per_mm = Projection(camera).pixels_per_mm(distance_mm);
  return std::max(1, static_cast<int>(2 * kSurroundings * radius_mm * pixels_per_mm / kGridPoints));
}

/// What was measured around the ball, on a grid of pixels.
Points points_around_ball(const Image<float>& depth_mm, const RayTable& rays, const Point3& centre,
                          double radius_mm) {
  const int step = grid_step(rays.camera(), centre, radius_mm);
  const auto near = static_cast<float>(radius_mm);
  const auto far = static_cast<float>(kSurroundings * radius_mm);
  const Eigen::Vector3f middle = centre.cast<float>();
  Points points;
  for (int row = step / 2; row < depth_mm.height(); row += step) {
    for (int column = step / 2; column < depth_mm.width(); column += step) {
      const float depth = depth_mm(column, row);
      if (!is_measured(depth) || std::abs(depth - middle.z()) > far) continue;
      const Eigen::Vector3f point(rays.x(column, row, depth), rays.y(column, row, depth), depth);
      const float squared_distance = (point - middle).squaredNorm();
      if (squared_distance > near * near && squared_distance <= far * far) points.push_back(point);
    }
  }
  return points;
}

/// Of points in a line it is not a number, and nothing lies near to it.
Plane plane_through(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  const Eigen::Vector3f normal = (b - a).cross(c - a);
  const float length = normal.norm();
  return {normal / length, normal.dot(a) / length};
}

/// Of random planes through three of the points the one that most of them lie near to.
std::optional<Plane> plane_of_most(const Points& points, float tolerance) {
  Random random(0x5F14CE);
  const auto any = [&] { return points[random.below(static_cast<std::uint32_t>(points.size()))]; };
  std::optional<Plane> best;
  std::ptrdiff_t most = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::Vector3f a = any();
    const Eigen::Vector3f b = any();
    const Plane plane = plane_through(a, b, any());
    const auto count = std::ranges::count_if(
        points, [&](const Eigen::Vector3f& point) { return plane.distance_mm(point) <= tolerance; });
    if (count > most) most = count, best = plane;
  }
  return best;
}

Points points_near(const Plane& plane, const Points& points, float tolerance) {
  Points near;
  std::ranges::copy_if(points, std::back_inserter(near),
                       [&](const Eigen::Vector3f& point) { return plane.distance_mm(point) <= tolerance; });
  return near;
}

/// The plane with the least squared distances.
Plane fitted_plane(const Points& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& point : points) mean += point.cast<double>();
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d off = point.cast<double>() - mean;
    scatter += off * off.transpose();
  }
  const Eigen::Vector3d normal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  return {normal.cast<float>(), static_cast<float>(normal.dot(mean))};
}

/// In how many of all directions along the plane, seen from the foot of `centre`, points lie.
int directions_of(const Plane& plane, const Points& points, const Point3& centre) {
  const Eigen::Vector3f along = plane.normal.unitOrthogonal();
  const Eigen::Vector3f across = plane.normal.cross(along);
  unsigned seen = 0;
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3f off = point - centre.cast<float>();
    const float turn = std::atan2(across.dot(off), along.dot(off)) / (2 * std::numbers::pi_v<float>)+0.5f;
    seen |= 1u << std::min(static_cast<int>(turn * kDirections), kDirections - 1);
  }
  return std::popcount(seen);
}

float deviation_mm(const Plane& plane, const Points& points) {
  std::vector<float> distances;
  for (const Eigen::Vector3f& point : points) distances.push_back(plane.distance_mm(point));
  const auto middle = distances.begin() + std::ssize(distances) / 2;
  std::ranges::nth_element(distances, middle);
  return 1.4826f * *middle;
}

/// Turned so that its normal points to where it is seen from.
SurfaceBehind seen_surface(Plane plane, float deviation, const Camera& camera) {
  const bool is_parallel = camera.model == CameraModel::orthographic;
  const float camera_height = is_parallel ? -plane.normal.z() : -plane.offset_mm;
  if (camera_height < 0) plane = {-plane.normal, -plane.offset_mm};
  return {plane.normal, plane.offset_mm, deviation};
}

}  // namespace

float SurfaceBehind::thickness_mm() const {
  return std::clamp(3.0f * deviation_mm, 6.0f, 15.0f);
}

std::optional<SurfaceBehind> surface_behind(const Image<float>& depth_mm, const RayTable& rays,
                                            const Point3& centre, double radius_mm) {
  const Points around = points_around_ball(depth_mm, rays, centre, radius_mm);
  if (around.size() < kFewestPoints) return std::nullopt;
  const float tolerance = tolerance_mm(centre);
  const std::optional<Plane> rough = plane_of_most(around, tolerance);
  if (!rough) return std::nullopt;
  const Points on_it = points_near(*rough, around, tolerance);
  if (static_cast<float>(on_it.size()) < kLeastShare * static_cast<float>(around.size())) return std::nullopt;
  const Plane plane = fitted_plane(on_it);
  if (directions_of(plane, on_it, centre) < kFewestDirections) return std::nullopt;
  return seen_surface(plane, deviation_mm(plane, on_it), rays.camera());
}

}  // namespace knuckle
