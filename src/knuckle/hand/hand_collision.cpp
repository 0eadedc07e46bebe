// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_collision.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "knuckle/hand/landmark_points.h"

namespace knuckle {
namespace {

/// Half the thickness of each phalanx and of the palm in parts of the distance from the wrist to the middle
/// MCP (about 95 mm; thicknesses of the fingers after Garrett, "The adult human hand", 1971).
constexpr std::array<double, 3> kFingerRadii = {0.085, 0.078, 0.068};
constexpr std::array<double, 3> kThumbRadii = {0.110, 0.098, 0.085};
constexpr double kPalmRadius = 0.115;

/// The shares of two segments' ways at which they are nearest (Ericson, "Real-time collision detection",
/// 2005, section 5.1.9).
std::pair<double, double> nearest_shares(const HandCapsule& a, const HandCapsule& b) {
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
  return {s, t};
}

/// From the second one's nearest place to the first one's.
Eigen::Vector3d way_between(const HandCapsule& a, const HandCapsule& b, const std::pair<double, double>& at) {
  const Point3 between = a.from - b.from;
  return between + at.first * (a.to - a.from) - at.second * (b.to - b.from);
}

double distance_of_segments(const HandCapsule& a, const HandCapsule& b) {
  return way_between(a, b, nearest_shares(a, b)).norm();
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

constexpr std::size_t kBones = 19;

/// Landmarks between which a bone lies.
struct BoneLine {
  int from;
  int to;
};

/// Three of each digit from the palm outwards, and after those of each finger the one from the wrist to it.
const std::array<BoneLine, kBones>& bone_lines() {
  static const std::array<BoneLine, kBones> lines = [] {
    std::array<BoneLine, kBones> all{};
    std::size_t count = 0;
    for (int digit = 0; digit < 5; ++digit) {
      const int root = static_cast<int>(landmark_of_digit(digit, 0));
      for (int part = 0; part < 3; ++part) all[count++] = {root + part, root + part + 1};
      if (digit > 0) all[count++] = {static_cast<int>(Landmark::wrist), root};
    }
    return all;
  }();
  return lines;
}

std::array<HandCapsule, kBones> capsules_of(const std::array<Point3, kSupersetSize>& landmarks) {
  const auto at = [&](int index) { return landmarks[static_cast<std::size_t>(index)]; };
  const double unit =
      (at(static_cast<int>(Landmark::middle_mcp)) - at(static_cast<int>(Landmark::wrist))).norm();
  std::array<HandCapsule, kBones> capsules;
  std::size_t count = 0;
  const auto add = [&](double radius, int digit, int part) {
    const BoneLine& line = bone_lines()[count];
    capsules[count++] = {at(line.from), at(line.to), radius * unit, digit, part};
  };
  for (int digit = 0; digit < 5; ++digit) {
    const auto& radii = digit == 0 ? kThumbRadii : kFingerRadii;
    for (int part = 0; part < 3; ++part) add(radii[static_cast<std::size_t>(part)], digit, part);
    if (digit > 0) add(kPalmRadius, HandCapsule::kPalmCapsule, digit);
  }
  return capsules;
}

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
/// The bones that are meant to be apart, by their numbers.
const Pairs& colliding_pairs() {
  static const Pairs pairs = [] {
    // Which bones they are does not depend on where they lie.
    std::array<Point3, kSupersetSize> anywhere;
    anywhere.fill(Point3::Zero());
    const auto capsules = capsules_of(anywhere);
    Pairs all;
    for (std::size_t i = 0; i < kBones; ++i) {
      for (std::size_t j = i + 1; j < kBones; ++j) {
        if (may_collide(capsules[i], capsules[j])) all.emplace_back(i, j);
      }
    }
    return all;
  }();
  return pairs;
}

}  // namespace

std::vector<HandCapsule> hand_capsules(const std::array<Point3, kSupersetSize>& landmarks) {
  const auto capsules = capsules_of(landmarks);
  return {capsules.begin(), capsules.end()};
}

BoneCollisions collisions_of(const std::array<Point3, kSupersetSize>& landmarks, double most_mm) {
  const auto capsules = capsules_of(landmarks);
  BoneCollisions found;
  for (const auto& [i, j] : colliding_pairs()) {
    const HandCapsule& a = capsules[i];
    const HandCapsule& b = capsules[j];
    const double radii = a.radius + b.radius;
    const auto shares = nearest_shares(a, b);
    const Eigen::Vector3d way = way_between(a, b, shares);
    const double distance = way.norm();
    if (!(radii - distance > most_mm)) continue;
    BoneCollision& collision = found.collisions[found.count++];
    collision = {{bone_lines()[i].from, bone_lines()[i].to, shares.first},
                 {bone_lines()[j].from, bone_lines()[j].to, shares.second}};
    if (distance > 0.0) collision.normal = way / distance;
    collision.radii_mm = radii;
    collision.depth_mm = radii - distance;
  }
  return found;
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
  double worst = 0.0;
  for (const BoneCollision& collision : collisions_of(landmarks, 0.0))
    worst = std::max(worst, collision.depth_mm);
  return worst;
}

}  // namespace knuckle
