// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "knuckle/hand/body_rig.h"
#include "knuckle/synth/exact_frame.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/render/view_culling.h"
#include "knuckle/synth/scene/placement.h"

namespace knuckle {

/// One of the manifest's people, ready to be posed.
struct ScenePerson {
  const BodyRig* rig = nullptr;
  const ViewCulling* culling = nullptr;
  const std::vector<float>* along_mm = nullptr;  ///< `way_along_arm`
};

/// Draws people among things, as the `[scene]` table of a manifest asks for.
class SceneRenderer {
 public:
  SceneRenderer(const Manifest& manifest, const Body& body);

  /// The exact picture of a right hand. `seed` is that of the scene. Safe to call from many threads.
  ExactFrame render_frame(const ScenePerson& person, const PlacedPosture& placed, const Camera& camera,
                          std::uint64_t seed) const;

 private:
  using Faces = std::vector<std::array<std::int32_t, 3>>;

  /// What is drawn, and where its groups of faces end: hand, person, and then things.
  struct Drawing;
  Drawing drawing_of(const ScenePerson& person, const PlacedPosture& placed, const Camera& camera,
                     std::uint64_t seed) const;
  void add_cut_arm(Drawing& drawing, const std::vector<float>& along_mm, float cut_mm) const;
  void dress(Drawing& drawing, const ScenePerson& person, const PosedBody& posed, std::uint64_t seed) const;
  ExactFrame seen(const Drawing& drawing, const Camera& camera) const;

  SceneOptions options_;
  bool needs_angles_;
  Skinning skinning_;
  Faces hand_faces_;
  Faces limb_faces_;   ///< of hand and arm
  Faces arm_faces_;    ///< of the arm alone
  Faces trunk_faces_;  ///< of the rest, without the left hand: none is seen that truth does not tell of
};

}  // namespace knuckle
