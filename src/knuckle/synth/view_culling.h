// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/synth/skinning.h"

namespace knuckle {

/// Says how much of one person has to be skinned and drawn: the smallest of the body's sections beyond which
/// nothing can be seen. The picture is the same as that of the whole body.
class ViewCulling {
 public:
  explicit ViewCulling(const ShapedBody& person);

  /// `transforms` are those of `bone_transforms`. The whole body where it has no sections, or where the
  /// camera is distorted and its view has no flat sides.
  BodySection visible_section(const std::vector<Eigen::Matrix4f>& transforms, const Camera& camera) const;

 private:
  /// All vertices between two sections that one bone moves lie in it, at rest.
  struct Ball {
    std::int32_t bone;
    Eigen::Vector3f centre;
    float radius;
  };

  BodySection whole_;
  std::vector<BodySection> sections_;
  std::vector<std::vector<Ball>> beyond_;  ///< one a section: balls of what it leaves out, up to the next
};

}  // namespace knuckle
