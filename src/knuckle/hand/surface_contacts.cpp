// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/surface_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>

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
    Cone& cone = cones_[i];
    cone.from = landmarks[static_cast<std::size_t>(flesh.from)];
    const Eigen::Vector3d line = landmarks[static_cast<std::size_t>(flesh.to)] - cone.from;
    cone.length = std::max(line.norm(), kShortestMm);
    cone.axis = line / cone.length;
    cone.radius = flesh.radius_from * palm_mm;
    const double growth = (flesh.radius_to - flesh.radius_from) * palm_mm / cone.length;
    cone.growth = std::clamp(growth, -kSteepest, kSteepest);
    cone.leaning = cone.growth / std::sqrt(1.0 - cone.growth * cone.growth);
  }
}

SurfaceContact PosedFlesh::contact(std::size_t number, double share, const Point3& point) const {
  const Cone& cone = cones_[number];
  const Eigen::Vector3d away = cone.from + share * cone.length * cone.axis - point;
  const double distance = away.norm();
  SurfaceContact contact{.flesh = &hand_flesh()[number], .share = share};
  if (distance > 0.0) contact.normal = away / distance;
  contact.radius_mm = cone.radius + share * cone.length * cone.growth;
  contact.gap_mm = distance - contact.radius_mm;
  return contact;
}

// The place on a cone's line is not straight below the point, but where the skin's normal leads: there the
// gap is least, and does not change with the share.
SurfaceContact PosedFlesh::nearest(const Point3& point) const {
  double least = std::numeric_limits<double>::infinity();
  double share = 0.0;
  std::size_t number = 0;
  for (std::size_t i = 0; i < kFleshCount; ++i) {
    const Cone& cone = cones_[i];
    const Eigen::Vector3d away = point - cone.from;
    const double along = cone.axis.dot(away);
    const double across_squared = std::max(0.0, away.squaredNorm() - along * along);
    const double place = std::clamp(along + std::sqrt(across_squared) * cone.leaning, 0.0, cone.length);
    const double gap =
        std::sqrt(across_squared + (along - place) * (along - place)) - cone.radius - place * cone.growth;
    if (gap >= least) continue;
    least = gap;
    share = place / cone.length;
    number = i;
  }
  return contact(number, share, point);
}

SurfaceContact PosedFlesh::floating(const HandSurface& surface, int number) const {
  if (!surface.depth_mm || surface.points.empty()) return {};
  const auto flesh = static_cast<std::size_t>(number / 2);
  const double share = number % 2 == 0 ? 0.5 : 1.0;
  const Point3 place = cones_[flesh].from + share * cones_[flesh].length * cones_[flesh].axis;
  const double measured = surface.depth_mm(place);
  if (!(measured > place.z() + kClearlyMm)) return {};
  const SurfaceContact found = contact(flesh, share, nearest_point(surface.points, place));
  return found.gap_mm > 0.0 ? found : SurfaceContact{};
}

}  // namespace knuckle
