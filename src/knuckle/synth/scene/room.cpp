// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/room.h"

#include <numbers>

#include "knuckle/synth/scene/sampling.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

/// Near walls are as likely as far ones: a wall 0.1 m behind matters more than how far a far one is.
float sampled_distance(Random& random) {
  constexpr double kNearMm = 40.0;
  constexpr double kFarMm = 2500.0;
  const double place = random.uniform();
  return static_cast<float>(kNearMm + (kFarMm - kNearMm) * place * place * place);
}

}  // namespace

Room sampled_room(const SceneActors& actors, const std::optional<Table>& table, Random& random) {
  const Vector3f up = table ? table->up() : actors.up;
  const Vector3f palm = actors.palm().cast<float>();
  Room room;
  room.camera_from_room = standing(palm, up, random.uniform(0.0, 2.0 * std::numbers::pi));
  const Eigen::Isometry3f room_from_camera = room.camera_from_room.inverse();
  Eigen::AlignedBox3f needed(room_from_camera.translation());
  for (const Vector3f& point : actors.points) needed.extend(room_from_camera * point);
  for (int axis = 0; axis < 2; ++axis) {
    room.inside.min()[axis] = needed.min()[axis] - sampled_distance(random);
    room.inside.max()[axis] = needed.max()[axis] + sampled_distance(random);
  }
  room.inside.max().z() = needed.max().z() + between(random, 200, 1500);
  room.inside.min().z() = needed.min().z() - between(random, 50, 900);
  if (table) {
    const Vector3f foot = table->camera_from_table * Vector3f(0.0f, 0.0f, -table->height);
    room.inside.min().z() = std::min((room_from_camera * foot).z(), needed.min().z());
  }
  const float floor = room.inside.min().z();
  room.camera_from_room.translation() += up * floor;
  room.inside.translate(Vector3f(0.0f, 0.0f, -floor));
  return room;
}

SceneMesh mesh_of(const Room& room) {
  SceneMesh mesh;
  std::array<Vector3f, 8> corners;
  for (int i = 0; i < 8; ++i) {
    const auto corner = static_cast<Eigen::AlignedBox3f::CornerType>(i);
    corners[i] = room.camera_from_room * room.inside.corner(corner);
  }
  // Those of a box, looked at from inside.
  constexpr std::array<std::array<int, 4>, 6> kSides = {
      {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
  for (const auto& [a, b, c, d] : kSides) mesh.add_quad({corners[a], corners[b], corners[c], corners[d]});
  return mesh;
}

}  // namespace knuckle
