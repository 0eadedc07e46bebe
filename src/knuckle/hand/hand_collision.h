// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "knuckle/core/pose.h"

namespace knuckle {

/// A bone with the flesh around it: all points within `radius` of a segment [mm].
struct HandCapsule {
  Point3 from;
  Point3 to;
  double radius = 0.0;
  int digit = 0;  ///< 0 thumb to 4 little, or kPalmCapsule
  int part = 0;   ///< 0 next to the palm; of the palm: towards which finger, 1 index to 4 little
  static constexpr int kPalmCapsule = 5;
};

/// The bones of a hand as capsules, as thick as an adult's in proportion to the palm: three per digit, from
/// the thumb outwards, and after those of each finger one from the wrist to its MCP.
std::vector<HandCapsule> hand_capsules(const std::array<Point3, kSupersetSize>& landmarks);

/// How far two capsules are apart; negative: how deep they run into one another [mm].
double gap_mm(const HandCapsule& a, const HandCapsule& b);

/// The least gap between the bones of two hands [mm].
double gap_of_hands_mm(const std::vector<HandCapsule>& a, const std::vector<HandCapsule>& b);

/// Two bones of a hand that run into one another, where they are nearest.
struct BoneCollision {
  /// A place on the line of a bone.
  struct Place {
    int from = 0;        ///< landmark where the bone begins
    int to = 0;          ///< and where it ends
    double share = 0.0;  ///< of the way between them
  };
  Place one;
  Place other;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< from the other place to the one, of length 1
  double radii_mm = 0.0;                              ///< both together
  double depth_mm = 0.0;                              ///< how deep they run into one another
};

/// Collisions of a hand; holds them without allocating.
struct BoneCollisions {
  static constexpr std::size_t kMost = 171;  // pairs of 19 bones
  std::array<BoneCollision, kMost> collisions;
  std::size_t count = 0;

  auto begin() const { return collisions.begin(); }
  auto end() const { return collisions.begin() + static_cast<std::ptrdiff_t>(count); }
};

/// All that are deeper than `most_mm`, of the bones that `worst_penetration_mm` counts.
BoneCollisions collisions_of(const std::array<Point3, kSupersetSize>& landmarks, double most_mm);

/// How deep digits run into one another or into the palm, at the worst place [mm]; 0 where they do not. Bones
/// are capsules as thick as an adult's in proportion to the palm; what is jointed, and the sides of
/// neighbouring fingers at their roots, does not count.
double worst_penetration_mm(const std::array<Point3, kSupersetSize>& landmarks);

}  // namespace knuckle
