// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/flesh_cone.h"

#include <algorithm>
#include <cmath>

#include "knuckle/hand/hand_flesh.h"

namespace knuckle {
namespace {

/// The ray comes from outside: the smaller solution of a t^2 + 2 b t + c = 0 is where it enters.
std::optional<double> entry(double a, double b, double c) {
  const double root = b * b - a * c;
  if (!(root >= 0.0) || a == 0.0) return std::nullopt;
  return (-b - std::sqrt(root)) / a;
}

void keep_first(std::optional<SkinHit>& first, double distance, const Eigen::Vector3d& normal) {
  if (distance > 0.0 && std::isfinite(distance) && (!first || distance < first->distance))
    first = SkinHit{distance, normal};
}

void meet_sphere(std::optional<SkinHit>& first, const Point3& centre, double radius, const Point3& origin,
                 const Eigen::Vector3d& direction) {
  const Eigen::Vector3d away = origin - centre;
  const auto t = entry(direction.squaredNorm(), away.dot(direction), away.squaredNorm() - radius * radius);
  if (t) keep_first(first, *t, (away + *t * direction) / radius);
}

/// The side of a cone, where its skin belongs to a sphere between the two ends. With y along the axis and rho
/// away from it, the sides of all spheres of radius r - k y touch the lines cos rho = r - k y, where
/// cos^2 = 1 - k^2; squared, that is quadratic along the ray. Where one end holds the other,
/// cos^2 < 0 and nothing solves it.
void meet_side(std::optional<SkinHit>& first, const FleshCone& cone, const Point3& origin,
               const Eigen::Vector3d& direction) {
  const Eigen::Vector3d line = cone.to - cone.from;
  const double length = line.norm();
  if (!(length > 0.0)) return;
  const double k = (cone.radius_from - cone.radius_to) / length;
  const double cos2 = 1.0 - k * k;
  const Eigen::Vector3d axis = line / length;
  const Eigen::Vector3d away = origin - cone.from;
  const double y0 = away.dot(axis);
  const double slope = direction.dot(axis);
  const double r = cone.radius_from;
  const auto t = entry(cos2 * direction.squaredNorm() - slope * slope,
                       cos2 * away.dot(direction) - y0 * slope + r * k * slope,
                       cos2 * away.squaredNorm() - y0 * y0 + 2.0 * r * k * y0 - r * r);
  if (!t) return;
  const double y = y0 + *t * slope;
  // The centre of the sphere that is touched there.
  const double centre = (y - r * k) / cos2;
  if (!(centre >= 0.0 && centre <= length)) return;
  const Eigen::Vector3d out = away + *t * direction - centre * axis;
  keep_first(first, *t, out.normalized());
}

/// Whether a ray passes by a ball around all of a cone, as most do.
bool passes_by(const FleshCone& cone, const Point3& origin, const Eigen::Vector3d& direction) {
  const double reach = 0.5 * (cone.to - cone.from).norm() + std::max(cone.radius_from, cone.radius_to);
  const Eigen::Vector3d away = 0.5 * (cone.from + cone.to) - origin;
  const double along = away.dot(direction);
  return away.squaredNorm() - along * along / direction.squaredNorm() > reach * reach;
}

}  // namespace

std::vector<FleshCone> flesh_cones(const SupersetPoints& landmarks) {
  const double palm_mm = palm_length(landmarks);
  if (!std::isfinite(palm_mm)) return {};
  std::vector<FleshCone> cones;
  for (const HandFlesh& flesh : hand_flesh()) {
    const Point3& from = landmarks[static_cast<std::size_t>(flesh.from)];
    const Point3& to = landmarks[static_cast<std::size_t>(flesh.to)];
    if (!from.allFinite() || !to.allFinite()) continue;
    cones.push_back({from, flesh.radius_from * palm_mm, to, flesh.radius_to * palm_mm});
  }
  return cones;
}

std::optional<SkinHit> first_hit(const FleshCone& cone, const Point3& origin,
                                 const Eigen::Vector3d& direction) {
  std::optional<SkinHit> first;
  if (passes_by(cone, origin, direction)) return first;
  meet_sphere(first, cone.from, cone.radius_from, origin, direction);
  meet_sphere(first, cone.to, cone.radius_to, origin, direction);
  meet_side(first, cone, origin, direction);
  return first;
}

}  // namespace knuckle
