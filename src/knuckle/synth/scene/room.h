// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "knuckle/core/random.h"
#include "knuckle/synth/scene/scene_actors.h"
#include "knuckle/synth/scene/scene_mesh.h"
#include "knuckle/synth/scene/table.h"

namespace knuckle {

/// A room as a box around camera and person, in its own axes: z is up, the origin lies on the floor below the
/// palm.
struct Room {
  Eigen::Isometry3f camera_from_room = Eigen::Isometry3f::Identity();
  Eigen::AlignedBox3f inside;  ///< [mm]
};

/// A room around all skin and the camera; with a table, its floor is what the table stands on.
Room sampled_room(const SceneActors& actors, const std::optional<Table>& table, Random& random);

/// Floor, walls and ceiling, seen from inside, in camera coordinates.
SceneMesh mesh_of(const Room& room);

}  // namespace knuckle
