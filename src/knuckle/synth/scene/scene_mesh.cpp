// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/scene_mesh.h"

namespace knuckle {

void SceneMesh::add_face(std::int32_t a, std::int32_t b, std::int32_t c, PixelLabel label) {
  faces.push_back({a, b, c});
  labels.push_back(label);
}

void SceneMesh::add_quad(const std::array<Eigen::Vector3f, 4>& corners, PixelLabel label) {
  const auto first = static_cast<std::int32_t>(vertices.size());
  vertices.insert(vertices.end(), corners.begin(), corners.end());
  add_face(first, first + 1, first + 2, label);
  add_face(first, first + 2, first + 3, label);
}

void SceneMesh::append(const SceneMesh& other, const Eigen::Isometry3f& place) {
  const auto first = static_cast<std::int32_t>(vertices.size());
  for (const Eigen::Vector3f& vertex : other.vertices) vertices.push_back(place * vertex);
  for (const auto& [a, b, c] : other.faces) faces.push_back({first + a, first + b, first + c});
  labels.insert(labels.end(), other.labels.begin(), other.labels.end());
}

void SceneMesh::append(std::span<const Eigen::Vector3f> new_vertices,
                       std::span<const std::array<std::int32_t, 3>> new_faces, PixelLabel label) {
  const auto first = static_cast<std::int32_t>(vertices.size());
  vertices.insert(vertices.end(), new_vertices.begin(), new_vertices.end());
  for (const auto& [a, b, c] : new_faces) faces.push_back({first + a, first + b, first + c});
  labels.insert(labels.end(), new_faces.size(), label);
}

}  // namespace knuckle
