// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/shapes.h"

#include <cmath>
#include <numbers>

#include "knuckle/core/portable_math.h"
#include "knuckle/hand/rotation_between.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

/// The unit circle's points.
std::vector<Eigen::Vector2f> circle(int sides) {
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    points.emplace_back(static_cast<float>(portable_cos(angle)), static_cast<float>(portable_sin(angle)));
  }
  return points;
}

/// Joins two rings of vertices, `below` and `above`, by faces that look outwards.
void join_rings(SceneMesh& mesh, std::int32_t below, std::int32_t above, int sides) {
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    mesh.add_face(below + i, below + next, above + next);
    mesh.add_face(below + i, above + next, above + i);
  }
}

/// Two directions across `along`, right-handed with it.
std::array<Vector3f, 2> across(const Vector3f& along) {
  const Vector3f other = std::abs(along.x()) < 0.7f ? Vector3f::UnitX() : Vector3f::UnitY();
  const Vector3f first = (other - along * along.dot(other)).normalized();
  return {first, along.cross(first)};
}

void close_ring(SceneMesh& mesh, std::int32_t ring, int sides, const Vector3f& centre, bool is_end) {
  const auto tip = static_cast<std::int32_t>(mesh.vertices.size());
  mesh.vertices.push_back(centre);
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    if (is_end) {
      mesh.add_face(ring + i, ring + next, tip);
    } else {
      mesh.add_face(ring + next, ring + i, tip);
    }
  }
}

}  // namespace

void Shape::append(const Shape& other, const Eigen::Isometry3f& place) {
  mesh.append(other.mesh, place);
  for (Solid solid : other.solids) {
    solid.thing_from_solid = place * solid.thing_from_solid;
    solids.push_back(solid);
  }
}

SceneMesh turned(std::span<const ProfilePoint> outline, int sides) {
  SceneMesh mesh;
  const std::vector<Eigen::Vector2f> points = circle(sides);
  std::int32_t below = -1;
  for (const auto& [radius, height] : outline) {
    const auto ring = static_cast<std::int32_t>(mesh.vertices.size());
    for (const Eigen::Vector2f& point : points)
      mesh.vertices.emplace_back(radius * point.x(), radius * point.y(), height);
    if (below >= 0) join_rings(mesh, below, ring, sides);
    below = ring;
  }
  return mesh;
}

SceneMesh tube(std::span<const Vector3f> line, float radius, int sides) {
  SceneMesh mesh;
  const std::vector<Eigen::Vector2f> points = circle(sides);
  Vector3f first = across((line[1] - line[0]).normalized())[0];
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector3f along = (line[std::min(i + 1, line.size() - 1)] - line[i == 0 ? 0 : i - 1]).normalized();
    first = (first - along * along.dot(first)).normalized();  // carried along without a twist
    const Vector3f second = along.cross(first);
    const auto ring = static_cast<std::int32_t>(mesh.vertices.size());
    for (const Eigen::Vector2f& point : points)
      mesh.vertices.push_back(line[i] + radius * (point.x() * first + point.y() * second));
    if (i > 0) join_rings(mesh, ring - sides, ring, sides);
  }
  const auto last = static_cast<std::int32_t>(mesh.vertices.size()) - sides;
  close_ring(mesh, 0, sides, line.front(), false);
  close_ring(mesh, last, sides, line.back(), true);
  return mesh;
}

Shape box_shape(const Vector3f& extents) {
  const Vector3f half = 0.5f * extents;
  Shape shape;
  SceneMesh& mesh = shape.mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                               (i & 4) != 0 ? extents.z() : 0.0f);
  }
  constexpr std::array<std::array<std::int32_t, 4>, 6> kSides = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& [a, b, c, d] : kSides) {
    mesh.add_face(a, b, c);
    mesh.add_face(a, c, d);
  }
  Solid solid{Solid::Kind::box, half, Eigen::Isometry3f::Identity()};
  solid.thing_from_solid.translation().z() = half.z();
  shape.solids.push_back(solid);
  return shape;
}

Shape cone_shape(float bottom_radius, float top_radius, float height, int sides) {
  Shape shape;
  const std::array<ProfilePoint, 4> outline = {
      {{0.0f, 0.0f}, {bottom_radius, 0.0f}, {top_radius, height}, {0.0f, height}}};
  shape.mesh = turned(outline, sides);
  Solid solid{Solid::Kind::cone, {bottom_radius, top_radius, 0.5f * height}, Eigen::Isometry3f::Identity()};
  solid.thing_from_solid.translation().z() = 0.5f * height;
  shape.solids.push_back(solid);
  return shape;
}

Shape ball_shape(float radius) {
  constexpr int kRings = 10;
  std::vector<ProfilePoint> outline;
  for (int i = 0; i <= kRings; ++i) {
    const double angle = std::numbers::pi * i / kRings;
    outline.push_back({radius * static_cast<float>(portable_sin(angle)),
                       radius * (1.0f - static_cast<float>(portable_cos(angle)))});
  }
  Shape shape;
  shape.mesh = turned(outline, 18);
  Solid solid{Solid::Kind::ball, Vector3f::Constant(radius), Eigen::Isometry3f::Identity()};
  solid.thing_from_solid.translation().z() = radius;
  shape.solids.push_back(solid);
  return shape;
}

Eigen::Isometry3f standing(const Vector3f& foot, const Vector3f& up, double turn) {
  const auto [first, second] = across(up);
  Eigen::Matrix3f axes;
  const auto c = static_cast<float>(portable_cos(turn));
  const auto s = static_cast<float>(portable_sin(turn));
  axes << c * first + s * second, c * second - s * first, up;
  Eigen::Isometry3f place = Eigen::Isometry3f::Identity();
  place.linear() = axes;
  place.translation() = foot;
  return place;
}

}  // namespace knuckle
