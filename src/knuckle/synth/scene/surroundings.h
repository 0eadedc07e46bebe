// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/synth/scene/scene_actors.h"
#include "knuckle/synth/scene/scene_mesh.h"
#include "knuckle/synth/scene/scene_options.h"

namespace knuckle {

/// What is around a hand, in camera coordinates, by how soon it is left out where it hides too much of it.
struct Surroundings {
  SceneMesh room;    ///< room, furniture and table
  SceneMesh things;  ///< what lies and stands about
  SceneMesh before;  ///< what reaches before the hand
};

/// Draws the surroundings of one scene: a function of its arguments alone. Each kind of thing has its own
/// random numbers, so one that is switched off changes nothing in the others.
Surroundings sampled_surroundings(const SceneActors& actors, const SceneOptions& options, std::uint64_t seed);

}  // namespace knuckle
