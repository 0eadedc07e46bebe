// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/clothes.h"

#include <algorithm>
#include <numbers>

#include "knuckle/core/portable_math.h"
#include "knuckle/synth/scene/sampling.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

/// A corner of the hose: on the skin, above it, and how far along the arm.
struct Corner3 {
  Vector3f skin;
  Vector3f cloth;
  float along;
};

Corner3 mixed(const Corner3& a, const Corner3& b, float along) {
  const float t = (along - a.along) / (b.along - a.along);
  return {a.skin + t * (b.skin - a.skin), a.cloth + t * (b.cloth - a.cloth), along};
}

/// The part of a polygon on one side of `limit`: beyond it, or before it where `sign` is -1.
std::vector<Corner3> cut(const std::vector<Corner3>& polygon, float limit, float sign) {
  std::vector<Corner3> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner3& a = polygon[i];
    const Corner3& b = polygon[(i + 1) % polygon.size()];
    const bool a_is_kept = sign * (a.along - limit) >= 0.0f;
    const bool b_is_kept = sign * (b.along - limit) >= 0.0f;
    if (a_is_kept) kept.push_back(a);
    if (a_is_kept != b_is_kept) kept.push_back(mixed(a, b, limit));
  }
  return kept;
}

std::vector<Vector3f> vertex_normals(const ArmSkin& skin) {
  std::vector<Vector3f> normals(skin.vertices.size(), Vector3f::Zero());
  for (const auto& [a, b, c] : skin.faces) {
    const Vector3f normal = (skin.vertices[b] - skin.vertices[a]).cross(skin.vertices[c] - skin.vertices[a]);
    for (const std::int32_t vertex : {a, b, c}) normals[vertex] += normal;
  }
  for (Vector3f& normal : normals) {
    const float length = normal.norm();
    if (length > 0.0f) normal /= length;
  }
  return normals;
}

float gap_at(const Hose& hose, const Vector3f& rest, float along) {
  constexpr float kFlareReach = 60.0f;  // [mm]
  const float to_end = std::clamp((along - hose.from_mm) / kFlareReach, 0.0f, 1.0f);
  float gap = hose.gap_mm + hose.flare_mm * (1.0f - to_end);
  if (hose.fold_mm == 0.0f) return gap;
  for (const Vector3f& fold : hose.folds)
    gap += hose.fold_mm * 0.5f * (1.0f + static_cast<float>(portable_sin(fold.dot(rest))));
  return gap;
}

void add_rim(SceneMesh& mesh, const Corner3& from, const Corner3& to) {
  mesh.add_quad({to.cloth, from.cloth, from.skin, to.skin}, PixelLabel::person);
}

void add_polygon(SceneMesh& mesh, const std::vector<Corner3>& polygon, const Hose& hose) {
  const auto first = static_cast<std::int32_t>(mesh.vertices.size());
  for (const Corner3& corner : polygon) mesh.vertices.push_back(corner.cloth);
  for (std::int32_t i = 2; i < std::ssize(polygon); ++i)
    mesh.add_face(first, first + i - 1, first + i, PixelLabel::person);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner3& from = polygon[i];
    const Corner3& to = polygon[(i + 1) % polygon.size()];
    const bool is_end = from.along == to.along && (from.along == hose.from_mm || from.along == hose.to_mm);
    if (is_end) add_rim(mesh, from, to);
  }
}

std::array<Vector3f, 3> sampled_folds(Random& random) {
  std::array<Vector3f, 3> folds;
  for (Vector3f& fold : folds) {
    const Vector3f direction = normal_vector(random);
    const float wavelength = between(random, 25, 90);
    fold = direction.normalized() * (2.0f * std::numbers::pi_v<float> / wavelength);
  }
  return folds;
}

}  // namespace

std::vector<float> way_along_arm(const ShapedBody& person) {
  const Body& body = *person.body;
  const auto joint = [&](std::string_view name) -> const Vector3f* {
    const auto found = std::ranges::find(body.names, name);
    return found == body.names.end() ? nullptr : &person.joints[found - body.names.begin()];
  };
  const Vector3f* wrist = joint("wrist.R");
  const Vector3f* elbow = joint("lowerarm01.R");
  if (elbow == nullptr) elbow = joint("lowerarm02.R");
  if (wrist == nullptr || elbow == nullptr) return {};
  const Vector3f direction = (*elbow - *wrist).normalized();
  const std::size_t count =
      body.sections.size() < 2 ? person.vertices.size() : static_cast<std::size_t>(body.sections[1].vertices);
  std::vector<float> along;
  for (std::size_t i = 0; i < count; ++i) along.push_back((person.vertices[i] - *wrist).dot(direction));
  return along;
}

Hose sampled_sleeve(Random& random) {
  Hose sleeve;
  // Most end near the wrist; rolled up and short ones anywhere.
  sleeve.from_mm = random.uniform() < 0.65 ? between(random, -35, 30) : between(random, 30, 300);
  sleeve.gap_mm = between(random, 1.5, 9);
  sleeve.flare_mm = random.uniform() < 0.5 ? between(random, 0, 22) : 0.0f;
  sleeve.fold_mm = between(random, 0, 3.5);
  sleeve.folds = sampled_folds(random);
  return sleeve;
}

Hose sampled_band(Random& random) {
  Hose band;
  band.from_mm = between(random, -15, 45);
  band.to_mm = band.from_mm + between(random, 6, 45);
  band.gap_mm = between(random, 1.5, 8);
  return band;
}

SceneMesh mesh_of(const Hose& hose, const ArmSkin& skin) {
  const std::vector<Vector3f> normals = vertex_normals(skin);
  std::vector<Vector3f> cloth(skin.along_mm.size());
  for (std::size_t i = 0; i < cloth.size(); ++i) {
    constexpr float kRoom = 40.0f;  // a body's faces reach no farther beyond the hose's ends [mm]
    const bool is_far = skin.along_mm[i] < hose.from_mm - kRoom || skin.along_mm[i] > hose.to_mm + kRoom;
    const float gap = is_far ? hose.gap_mm : gap_at(hose, skin.rest[i], skin.along_mm[i]);
    cloth[i] = skin.vertices[i] + normals[i] * gap;
  }
  SceneMesh mesh;
  for (const auto& face : skin.faces) {
    const auto along = [&](int corner) { return skin.along_mm[face[corner]]; };
    const float low = std::min({along(0), along(1), along(2)});
    const float high = std::max({along(0), along(1), along(2)});
    if (high <= hose.from_mm || low >= hose.to_mm) continue;
    std::vector<Corner3> polygon;
    for (const std::int32_t vertex : face)
      polygon.push_back({skin.vertices[vertex], cloth[vertex], skin.along_mm[vertex]});
    if (low < hose.from_mm) polygon = cut(polygon, hose.from_mm, 1.0f);
    if (high > hose.to_mm) polygon = cut(polygon, hose.to_mm, -1.0f);
    if (polygon.size() >= 3) add_polygon(mesh, polygon, hose);
  }
  return mesh;
}

}  // namespace knuckle
