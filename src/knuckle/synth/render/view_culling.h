// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/hand/skinning.h"

namespace knuckle {

/// Says how much of one person has to be skinned and drawn: what only the last of the body's sections has
/// (the trunk, not hand and arm) is left out where it cannot be seen. The picture is the same as that of the
/// whole body.
class ViewCulling {
 public:
  explicit ViewCulling(const ShapedBody& person);

  /// `transforms` are those of `bone_transforms`. The whole body where it has no sections, or where the
  /// camera is distorted and its view has no flat sides.
  BodySection visible_section(const std::vector<Eigen::Matrix4f>& transforms, const Camera& camera) const;

 private:
  /// All vertices of the trunk's faces that one bone moves lie in it, at rest.
  struct Ball {
    std::int32_t bone;
    Eigen::Vector3f centre;
    float radius;
  };

  BodySection whole_;
  BodySection limb_;         ///< all sections but the last
  std::vector<Ball> trunk_;  ///< balls of what the last section adds; empty where it cannot be left out
};

}  // namespace knuckle
