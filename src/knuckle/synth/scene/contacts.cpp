// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/contacts.h"

#include <algorithm>

namespace knuckle {
namespace {

constexpr float kCameraRoomMm = 60.0f;

/// The box around a thing's vertices, in its own axes.
Eigen::AlignedBox3f box_of(const Shape& shape, float margin) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : shape.mesh.vertices) box.extend(vertex);
  box.min().array() -= margin;
  box.max().array() += margin;
  return box;
}

}  // namespace

bool keeps_clear(const PlacedShape& thing, const SceneActors& actors, float clearance_mm) {
  const Eigen::Isometry3f shape_from_camera = thing.camera_from_shape.inverse();
  if (distance_mm(thing.shape.solids, shape_from_camera.translation()) < kCameraRoomMm) return false;
  const Eigen::AlignedBox3f box = box_of(thing.shape, std::max(clearance_mm, 0.0f));
  return std::ranges::none_of(actors.points, [&](const Eigen::Vector3f& point) {
    const Eigen::Vector3f place = shape_from_camera * point;
    return box.contains(place) && distance_mm(thing.shape.solids, place) < clearance_mm;
  });
}

}  // namespace knuckle
