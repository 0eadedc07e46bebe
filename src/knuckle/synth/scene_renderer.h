// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knuckle/hand/body_rig.h"
#include "knuckle/hand/hand_skeleton.h"
#include "knuckle/synth/exact_frame.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/pose/motion.h"
#include "knuckle/synth/render/view_culling.h"
#include "knuckle/synth/scene/grasp.h"
#include "knuckle/synth/scene/scene_actors.h"

namespace knuckle {

/// One of the manifest's people, ready to be posed.
struct ScenePerson {
  const BodyRig* rig = nullptr;
  const ViewCulling* culling = nullptr;
  const std::vector<float>* along_mm = nullptr;  ///< `way_along_arm`
  const HandSkeleton* skeleton = nullptr;        ///< of the right hand; needed where hands hold things
};

/// How the person stands in a frame, and in the sequence that it belongs to.
struct ScenePostures {
  PlacedPosture now;
  std::vector<PlacedPosture> sequence;  ///< some moments, the first first; empty: the frame stands alone
  std::int64_t frame = 0;               ///< its place in the sequence
};

/// Draws people among things, as the `[scene]` table of a manifest asks for. Safe to use from many threads.
class SceneRenderer {
 public:
  SceneRenderer(const Manifest& manifest, const Body& body);

  /// What the hand of a scene holds; nothing where it is free. `seed` is that of the scene.
  std::optional<Grasp> grasp_of_scene(const ScenePerson& person, std::uint64_t seed) const;

  /// The exact picture of a right hand, which holds `held` where that is not null.
  ExactFrame render_frame(const ScenePerson& person, const ScenePostures& postures, const Grasp* held,
                          const Camera& camera, std::uint64_t seed) const;

 private:
  using Faces = std::vector<std::array<std::int32_t, 3>>;
  struct SceneKind;
  struct Drawing;  ///< what is drawn, and where its groups of faces end

  /// All that a scene depends on.
  struct Cast {
    const ScenePerson& person;
    const ScenePostures& postures;
    const Grasp* held;
    const Camera& camera;
    std::uint64_t seed;

    const PlacedPosture& reference() const {
      return postures.sequence.empty() ? postures.now : postures.sequence.front();
    }
  };

  SceneKind kind_of(std::uint64_t seed) const;
  Drawing drawing_of(const Cast& cast, bool may_have_second) const;
  void add_person(Drawing& drawing, const Cast& cast, const SceneKind& kind) const;
  void add_cut_arm(Drawing& drawing, const std::vector<float>& along_mm, float cut_mm) const;
  std::vector<std::array<Point3, kSupersetSize>> landmarks_of_sequence(const Cast& cast) const;
  void add_second_hand(Drawing& drawing, const Cast& cast) const;
  void add_held(Drawing& drawing, const Cast& cast, const BodyPose& pose) const;
  void add_things(Drawing& drawing, const Cast& cast) const;
  SceneActors actors_of(const Cast& cast, const PosedBody& posed) const;
  void dress(Drawing& drawing, const Cast& cast, std::span<const Eigen::Vector3f> skin,
             const Faces& faces) const;
  struct Picture;
  Picture picture_of(const Drawing& drawing, std::size_t end, const Camera& camera) const;
  /// The first of the drawing's stages that shows enough of the hand, else the last.
  std::size_t stage_to_show(const Drawing& drawing, const Camera& camera) const;
  ExactFrame seen(const Drawing& drawing, const Camera& camera) const;
  ExactFrame frame_of_sequence(const Cast& cast) const;

  SceneOptions options_;
  PostureOptions postures_;
  bool needs_angles_;
  Skinning skinning_;
  std::size_t hand_vertices_ = 0;  ///< of the body; the hand's come first
  std::size_t limb_vertices_ = 0;  ///< of hand and arm
  Faces hand_faces_;
  Faces arm_faces_;
  Faces limb_faces_;     ///< of hand and arm
  Faces trunk_faces_;    ///< of the rest, without the left hand: none is seen that truth does not tell of
  Faces armless_faces_;  ///< of the rest, without the left arm, where the second hand has its own
};

}  // namespace knuckle
