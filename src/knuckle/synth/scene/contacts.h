// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/synth/scene/scene_actors.h"
#include "knuckle/synth/scene/shapes.h"

namespace knuckle {

/// A thing and where it is.
struct PlacedShape {
  Shape shape;
  Eigen::Isometry3f camera_from_shape = Eigen::Isometry3f::Identity();
};

/// Whether a thing keeps `clearance_mm` from all skin, and 60 mm from the camera. A negative clearance is how
/// deep skin may press into it.
bool keeps_clear(const PlacedShape& thing, const SceneActors& actors, float clearance_mm);

}  // namespace knuckle
