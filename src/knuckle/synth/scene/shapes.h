// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "knuckle/synth/scene/scene_mesh.h"
#include "knuckle/synth/scene/solid.h"

namespace knuckle {

/// A thing in its own axes: it stands on z = 0 about the z axis, which points up [mm].
struct Shape {
  SceneMesh mesh;
  std::vector<Solid> solids;  ///< what its surface is made of, for contacts

  /// Adds another thing, moved.
  void append(const Shape& other, const Eigen::Isometry3f& place);
};

/// A point of an outline that is turned about the z axis.
struct ProfilePoint {
  float radius;
  float height;
};

/// Faces of a surface of revolution. The outline goes so that outside is on its right, seen with radius to
/// the right and height up: a solid goes from the bottom's centre along the outside to the top's centre.
/// `sides`: at least 3.
SceneMesh turned(std::span<const ProfilePoint> outline, int sides);

/// A tube of one radius along a line of points, at least 2, with flat ends.
SceneMesh tube(std::span<const Eigen::Vector3f> line, float radius, int sides);

/// A box that stands on z = 0, of whole extents.
Shape box_shape(const Eigen::Vector3f& extents);
/// A round frustum that stands on z = 0.
Shape cone_shape(float bottom_radius, float top_radius, float height, int sides = 20);
/// A ball that lies on z = 0.
Shape ball_shape(float radius);

/// The turn and shift that put a thing's z axis along `up` (of length 1) at `foot`, after a turn of the thing
/// about its own z axis.
Eigen::Isometry3f standing(const Eigen::Vector3f& foot, const Eigen::Vector3f& up, double turn);

}  // namespace knuckle
