// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_collision.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace knuckle {
namespace {

/// Half the thickness of each phalanx and of the palm in parts of the distance from the wrist to the middle
/// MCP (about 95 mm; thicknesses of the fingers after Garrett, "The adult human hand", 1971).
constexpr std::array<double, 3> kFingerRadii = {0.085, 0.078, 0.068};
constexpr std::array<double, 3> kThumbRadii = {0.110, 0.098, 0.085};
constexpr double kPalmRadius = 0.115;

/// Least distance of two segments (Ericson, "Real-time collision detection", 2005, section 5.1.9).
double distance_of_segments(const HandCapsule& a, const HandCapsule& b) {
  const Point3 d1 = a.to - a.from;
  const Point3 d2 = b.to - b.from;
  const Point3 r = a.from - b.from;
  const double a11 = d1.squaredNorm();
  const double a22 = d2.squaredNorm();
  const double a12 = d1.dot(d2);
  const double c = d1.dot(r);
  const double f = d2.dot(r);
  const double determinant = a11 * a22 - a12 * a12;
  double s = determinant > 1e-9 * a11 * a22 ? std::clamp((a12 * f - c * a22) / determinant, 0.0, 1.0) : 0.0;
  const double t = std::clamp((a12 * s + f) / a22, 0.0, 1.0);
  s = std::clamp((a12 * t - c) / a11, 0.0, 1.0);
  return (r + s * d1 - t * d2).norm();
}

/// Whether two capsules are meant to be apart.
bool may_collide(const HandCapsule& a, const HandCapsule& b) {
  if (a.digit == b.digit) return false;
  if (a.digit == HandCapsule::kPalmCapsule || b.digit == HandCapsule::kPalmCapsule) {
    const HandCapsule& other = a.digit == HandCapsule::kPalmCapsule ? b : a;
    return other.digit == 0 ? other.part > 0 : other.part == 2;  // what is near the palm by its nature is not
  }
  const bool neighbours = a.digit > 0 && b.digit > 0 && std::abs(a.digit - b.digit) == 1;
  return !(neighbours && a.part == 0 && b.part == 0);
}

}  // namespace

std::vector<HandCapsule> hand_capsules(const std::array<Point3, kSupersetSize>& landmarks) {
  const auto at = [&](int index) { return landmarks[index]; };
  constexpr int kWrist = static_cast<int>(Landmark::wrist);
  constexpr int kFirst = static_cast<int>(Landmark::thumb_cmc);
  constexpr int kMiddleMcp = static_cast<int>(Landmark::middle_mcp);
  const double unit = (at(kMiddleMcp) - at(kWrist)).norm();
  std::vector<HandCapsule> capsules;
  for (int digit = 0; digit < 5; ++digit) {
    const int root = kFirst + 4 * digit;
    const auto& radii = digit == 0 ? kThumbRadii : kFingerRadii;
    for (int part = 0; part < 3; ++part) {
      capsules.push_back({at(root + part), at(root + part + 1), radii[part] * unit, digit, part});
    }
    if (digit > 0)
      capsules.push_back({at(kWrist), at(root), kPalmRadius * unit, HandCapsule::kPalmCapsule, digit});
  }
  return capsules;
}

double gap_mm(const HandCapsule& a, const HandCapsule& b) {
  return distance_of_segments(a, b) - a.radius - b.radius;
}

double gap_of_hands_mm(const std::vector<HandCapsule>& a, const std::vector<HandCapsule>& b) {
  double least = std::numeric_limits<double>::infinity();
  for (const HandCapsule& one : a) {
    for (const HandCapsule& other : b) least = std::min(least, gap_mm(one, other));
  }
  return least;
}

double worst_penetration_mm(const std::array<Point3, kSupersetSize>& landmarks) {
  const std::vector<HandCapsule> capsules = hand_capsules(landmarks);
  double worst = 0.0;
  for (std::size_t i = 0; i < capsules.size(); ++i) {
    for (std::size_t j = i + 1; j < capsules.size(); ++j) {
      const HandCapsule& a = capsules[i];
      const HandCapsule& b = capsules[j];
      if (may_collide(a, b)) worst = std::max(worst, a.radius + b.radius - distance_of_segments(a, b));
    }
  }
  return worst;
}

}  // namespace knuckle
