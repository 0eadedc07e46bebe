// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "knuckle/core/frame.h"
#include "knuckle/synth/render/rasteriser.h"

namespace knuckle {

/// Triangles of many things, counter-clockwise from outside, and what each of them belongs to. Lengths in mm.
struct SceneMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::int32_t, 3>> faces;
  std::vector<PixelLabel> labels;  ///< one per face

  void add_face(std::int32_t a, std::int32_t b, std::int32_t c, PixelLabel label = PixelLabel::object);
  /// Two triangles of four corners, counter-clockwise from outside.
  void add_quad(const std::array<Eigen::Vector3f, 4>& corners, PixelLabel label = PixelLabel::object);
  /// All of another mesh, moved.
  void append(const SceneMesh& other, const Eigen::Isometry3f& place);
  /// Some faces of a mesh that is in place, all with one label.
  void append(std::span<const Eigen::Vector3f> new_vertices,
              std::span<const std::array<std::int32_t, 3>> new_faces, PixelLabel label);

  TriangleMesh triangles() const { return {vertices, faces}; }
};

}  // namespace knuckle
