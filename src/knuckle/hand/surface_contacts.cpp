// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/surface_contacts.h"

#include <algorithm>
#include <cmath>

namespace knuckle {
namespace {

constexpr double kClearlyMm = 15.0;  ///< what lies less behind the flesh may be its own skin, seen with noise
constexpr double kSteepest = 0.9;  ///< growth of a cone; beyond 1 one of its round ends would hold the other
constexpr double kShortestMm = 1e-6;

const Point3& nearest_point(const std::vector<Point3>& points, const Point3& place) {
  return *std::ranges::min_element(points, {},
                                   [&](const Point3& point) { return (point - place).squaredNorm(); });
}

}  // namespace

PosedFlesh::PosedFlesh(const std::array<Point3, kSupersetSize>& landmarks, double palm_mm) {
  for (std::size_t i = 0; i < kFleshCount; ++i) {
    const HandFlesh& flesh = hand_flesh()[i];
    const Point3& from = landmarks[static_cast<std::size_t>(flesh.from)];
    const Eigen::Vector3d line = landmarks[static_cast<std::size_t>(flesh.to)] - from;
    const double length = std::max(line.norm(), kShortestMm);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cones_.from[axis][i] = from[static_cast<Eigen::Index>(axis)];
      cones_.axis[axis][i] = line[static_cast<Eigen::Index>(axis)] / length;
    }
    cones_.length[i] = length;
    cones_.radius[i] = flesh.radius_from * palm_mm;
    const double growth =
        std::clamp((flesh.radius_to - flesh.radius_from) * palm_mm / length, -kSteepest, kSteepest);
    cones_.growth[i] = growth;
    cones_.leaning[i] = growth / std::sqrt(1.0 - growth * growth);
  }
}

Point3 PosedFlesh::on_line(std::size_t number, double place_mm) const {
  Point3 place;
  for (std::size_t axis = 0; axis < 3; ++axis)
    place[static_cast<Eigen::Index>(axis)] = cones_.from[axis][number] + place_mm * cones_.axis[axis][number];
  return place;
}

SurfaceContact PosedFlesh::contact(std::size_t number, double share, const Point3& point) const {
  const double place = share * cones_.length[number];
  const Eigen::Vector3d away = on_line(number, place) - point;
  const double distance = away.norm();
  SurfaceContact contact{.flesh = &hand_flesh()[number], .share = share};
  if (distance > 0.0) contact.normal = away / distance;
  contact.radius_mm = cones_.radius[number] + place * cones_.growth[number];
  contact.gap_mm = distance - contact.radius_mm;
  return contact;
}

// The place on a cone's line is not straight below the point, but where the skin's normal leads: there the
// gap is least, and does not change with the share.
SurfaceContact PosedFlesh::nearest(const Point3& point) const {
  Numbers places;
  Numbers gaps;
  const double point_x = point.x();
  const double point_y = point.y();
  const double point_z = point.z();
  for (std::size_t i = 0; i < kRoom; ++i) {  // the compiler works on several at once
    const double x = point_x - cones_.from[0][i];
    const double y = point_y - cones_.from[1][i];
    const double z = point_z - cones_.from[2][i];
    const double along = cones_.axis[0][i] * x + (cones_.axis[1][i] * y + cones_.axis[2][i] * z);
    const double across_squared = std::max(0.0, x * x + (y * y + z * z) - along * along);
    const double leaned = along + std::sqrt(across_squared) * cones_.leaning[i];
    const double place = std::min(std::max(leaned, 0.0), cones_.length[i]);
    places[i] = place;
    gaps[i] = std::sqrt(across_squared + (along - place) * (along - place)) - cones_.radius[i] -
              place * cones_.growth[i];
  }
  const auto least = std::min_element(gaps.begin(), gaps.begin() + kFleshCount);
  const auto number = static_cast<std::size_t>(least - gaps.begin());
  return contact(number, places[number] / cones_.length[number], point);
}

SurfaceContact PosedFlesh::floating(const HandSurface& surface, int number) const {
  if (!surface.depth_mm || surface.points.empty()) return {};
  const auto flesh = static_cast<std::size_t>(number / 2);
  const double share = number % 2 == 0 ? 0.5 : 1.0;
  const Point3 place = on_line(flesh, share * cones_.length[flesh]);
  const double measured = surface.depth_mm(place);
  if (!(measured > place.z() + kClearlyMm)) return {};
  const SurfaceContact found = contact(flesh, share, nearest_point(surface.points, place));
  return found.gap_mm > 0.0 ? found : SurfaceContact{};
}

}  // namespace knuckle
