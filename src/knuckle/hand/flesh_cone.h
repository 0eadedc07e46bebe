// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/hand/landmark_definition.h"

namespace knuckle {

/// One piece of the flesh of a hand in a pose: all points that are nearer to the line between two points than
/// a radius that grows evenly from one to the other (a cone with round ends). In camera coordinates [mm].
struct FleshCone {
  Point3 from = Point3::Zero();
  double radius_from = 0.0;  ///< > 0
  Point3 to = Point3::Zero();
  double radius_to = 0.0;  ///< > 0
};

/// The flesh (hand_flesh) around the landmarks of a hand; no cones at landmarks that are not known, and none
/// at all where the length of the palm is not.
std::vector<FleshCone> flesh_cones(const SupersetPoints& landmarks);

/// Where a ray meets the skin.
struct SkinHit {
  double distance = 0.0;                              ///< in lengths of the ray's direction, above 0
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< out of the flesh, of length 1
};

/// Where the ray from `origin` along `direction` (of any length above 0) enters a cone; nothing where it
/// passes by.
std::optional<SkinHit> first_hit(const FleshCone& cone, const Point3& origin,
                                 const Eigen::Vector3d& direction);

}  // namespace knuckle
