// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "knuckle/core/landmarks.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// A point as a weighted mean of vertices.
struct VertexGroup {
  std::vector<std::int32_t> vertices;
  std::vector<float> weights;  ///< sum to 1
};

/// One direction in which the body's shape may change: offsets of some of its vertices.
struct ShapeDirection {
  std::string name;
  std::vector<std::int32_t> vertices;
  std::vector<Eigen::Vector3f> offsets_mm;
};

/// The beginning of the arrays of a body's mesh: its first `faces` use only its first `vertices`.
struct BodySection {
  std::int32_t vertices = 0;
  std::int32_t faces = 0;
  bool operator==(const BodySection&) const = default;
};

/// A skinned, morphable mesh, with arrays named after SMPL's and MANO's. Body axes: x to the body's left, y
/// up, z to the front; lengths in mm. Read and written by body_file.h.
struct Body {
  static constexpr int kBonesPerVertex = 4;

  std::vector<Eigen::Vector3f> v_template;         ///< V rest positions [mm]
  std::vector<std::array<std::int32_t, 3>> faces;  ///< F triangles, counter-clockwise from outside
  std::vector<std::array<std::int32_t, kBonesPerVertex>> weight_bones;  ///< V x 4 bones that move a vertex
  std::vector<std::array<float, kBonesPerVertex>> weights;              ///< V x 4, sum to 1
  std::vector<ShapeDirection> shapedirs;                                ///< K directions
  std::vector<std::string> names;                                       ///< B bones, parents before children
  std::vector<std::int32_t> parents;                                    ///< B, -1 for a root
  std::vector<VertexGroup> joint_regressor;                             ///< B bone heads at rest
  std::array<VertexGroup, kSupersetSize> landmark_regressor;            ///< the landmarks at rest
  std::array<std::int32_t, kSupersetSize> landmark_bones{};  ///< the bone that carries each landmark
  std::vector<std::uint8_t> is_hand;                         ///< F: 1 where a face belongs to the hand
  /// Growing sections, sorted from the hand outwards (hand; hand and arm; all), so that a frame skins and
  /// draws only what it needs. May be empty.
  std::vector<BodySection> sections;

  /// Index of the bone of that name. Throws an Error that names it where there is none.
  int bone(std::string_view name) const;
};

/// Throws an Error that starts with `what` where sizes disagree, a value is not finite, weights do not sum to
/// 1, or a parent does not come before its child.
void check(const Body& body, std::string_view what);

}  // namespace knuckle
