// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene_renderer.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/hand/body_skeleton.h"
#include "knuckle/synth/render/occlusion.h"
#include "knuckle/synth/render/surface_angle.h"
#include "knuckle/synth/scene/clothes.h"
#include "knuckle/synth/scene/contacts.h"
#include "knuckle/synth/scene/second_hand.h"
#include "knuckle/synth/scene/stump.h"
#include "knuckle/synth/scene/surroundings.h"

namespace knuckle {
namespace {

using Landmarks = std::array<Point3, kSupersetSize>;

// Streams of a scene's seed.
constexpr std::uint64_t kKind = 0;
constexpr std::uint64_t kSleeve = 1;
constexpr std::uint64_t kBand = 2;
constexpr std::uint64_t kAround = 3;
constexpr std::uint64_t kSecond = 4;
constexpr std::uint64_t kHeld = 5;
constexpr std::uint64_t kStump = 6;

Point3 elbow_of(const ShapedBody& person, const BodyPose& pose, const Landmarks& landmarks) {
  const auto found = std::ranges::find(person.body->names, "lowerarm01.R");
  if (found == person.body->names.end()) {
    const Point3& wrist = landmarks[static_cast<std::size_t>(Landmark::wrist)];
    return wrist + 2.0 * (wrist - landmarks[static_cast<std::size_t>(Landmark::middle_mcp)]);
  }
  const auto bone = found - person.body->names.begin();
  return (bone_transforms(person, pose)[bone] * person.joints[bone].homogeneous()).head<3>().cast<double>();
}

/// Whether a vertex hangs on a bone, or those below it, by more than half.
std::vector<bool> vertices_that_hang_on(std::string_view bone, const Body& body) {
  std::vector<bool> hangs(body.names.size());
  for (std::size_t i = 0; i < body.names.size(); ++i) {
    const std::int32_t parent = body.parents[i];
    hangs[i] = body.names[i] == bone || (parent >= 0 && hangs[parent]);
  }
  std::vector<bool> vertices(body.v_template.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    float share = 0.0f;
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
      if (hangs[body.weight_bones[v][k]]) share += body.weights[v][k];
    }
    vertices[v] = share > 0.5f;
  }
  return vertices;
}

HandPose in_image(const Landmarks& landmarks, const Camera& camera) {
  const Projection projection(camera);
  HandPose pose{superset_convention(), {}, {}};
  for (const Point3& landmark : landmarks) pose.joints.push_back(projection.to_image(landmark));
  return pose;
}

std::int64_t seen_pixels(const Rendering& rendering) {
  return std::ranges::count_if(rendering.face.pixels(),
                               [](std::int32_t face) { return face != Rendering::kNoFace; });
}

Image<std::uint8_t> labels_of(const Rendering& rendering, const std::vector<PixelLabel>& face_labels) {
  Image<std::uint8_t> labels(rendering.face.width(), rendering.face.height());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::int32_t face = rendering.face.data()[i];
    const PixelLabel label = face == Rendering::kNoFace ? PixelLabel::nothing : face_labels[face];
    labels.data()[i] = static_cast<std::uint8_t>(label);
  }
  return labels;
}

Image<std::uint8_t> mask_of_label(const Image<std::uint8_t>& labels, PixelLabel label) {
  Image<std::uint8_t> mask(labels.width(), labels.height());
  std::ranges::transform(labels.pixels(), mask.data(), [&](std::uint8_t pixel) {
    return static_cast<std::uint8_t>(pixel == static_cast<std::uint8_t>(label) ? 1 : 0);
  });
  return mask;
}

/// The part of what a rendering shows alone that still has its label among all; 0 where it shows nothing.
double visible_share_of(const Rendering& alone, const Image<std::uint8_t>& labels, PixelLabel label) {
  const std::int64_t whole = seen_pixels(alone);
  const auto visible = std::ranges::count(labels.pixels(), static_cast<std::uint8_t>(label));
  return whole > 0 ? static_cast<double>(visible) / static_cast<double>(whole) : 0.0;
}

/// A skin that is at `phase` of a path, at some places along it: the same ones whatever the phase.
std::vector<Eigen::Vector3f> places_along(const HandPath& path, double phase,
                                          std::span<const Eigen::Vector3f> skin) {
  constexpr int kPlaces = 5;  // of one way
  std::vector<Eigen::Vector3f> places;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector3d shift = path.shift(0.5 * i / (kPlaces - 1)) - path.shift(phase);
    for (const Eigen::Vector3f& point : skin) places.emplace_back(point + shift.cast<float>());
  }
  return places;
}

}  // namespace

/// What a scene is about.
struct SceneRenderer::SceneKind {
  bool is_empty = false;        ///< there is no hand
  bool has_trunk = true;        ///< an empty scene may still show a face,
  std::optional<Stump> stump;   ///< and an arm that ends here
  std::optional<float> cut_mm;  ///< the arm ends here, along the arm; then there is nothing else
};

struct SceneRenderer::Drawing {
  SceneMesh mesh;
  std::size_t hand_end = 0;    ///< faces of the hand come first,
  std::size_t second_end = 0;  ///< then those of the second hand,
  std::size_t person_end = 0;  ///< then those of arms, trunk and clothes,
  std::size_t held_end = 0;    ///< then what the hand holds,
  std::vector<std::size_t>
      stages;  ///< and then things: where faces end with all of them, with less, with none
  Landmarks landmarks;
  std::optional<SecondHand> second;
  std::vector<Eigen::Vector3f> second_places;  ///< its skin all along its path, of one that passes
  SceneActors actors;
  bool has_hand = true;

  /// Faces of vertices that are in the mesh from `first` on.
  void add_faces(const Faces& faces, PixelLabel label, std::size_t first = 0) {
    const auto shift = static_cast<std::int32_t>(first);
    for (const auto& [a, b, c] : faces) mesh.add_face(shift + a, shift + b, shift + c, label);
  }
  /// The same of faces that were reflected, and so are inside out.
  void add_reflected_faces(const Faces& faces, PixelLabel label, std::size_t first) {
    const auto shift = static_cast<std::int32_t>(first);
    for (const auto& [a, b, c] : faces) mesh.add_face(shift + a, shift + c, shift + b, label);
  }
};

SceneRenderer::SceneRenderer(const Manifest& manifest, const Body& body)
    : options_(manifest.scene),
      postures_{manifest.pose, manifest.placement, manifest.motion},
      needs_angles_(manifest.sensor.needs_angles()),
      skinning_(manifest.body.skinning == "linear" ? Skinning::linear : Skinning::dual_quaternion) {
  const bool has_sections = body.sections.size() >= 2;
  const std::size_t limb_end =
      has_sections ? static_cast<std::size_t>(body.sections[1].faces) : body.faces.size();
  limb_vertices_ =
      has_sections ? static_cast<std::size_t>(body.sections[1].vertices) : body.v_template.size();
  hand_vertices_ = has_sections ? static_cast<std::size_t>(body.sections[0].vertices) : limb_vertices_;
  const std::vector<bool> is_left_hand = vertices_that_hang_on("wrist.L", body);
  const std::vector<bool> is_left_arm = vertices_that_hang_on("upperarm01.L", body);
  for (std::size_t f = 0; f < body.faces.size(); ++f) {
    const auto& face = body.faces[f];
    if (f < limb_end) {
      limb_faces_.push_back(face);
      (body.is_hand[f] != 0 ? hand_faces_ : arm_faces_).push_back(face);
      continue;
    }
    if (!is_left_hand[face[0]]) trunk_faces_.push_back(face);
    if (!is_left_arm[face[0]]) armless_faces_.push_back(face);
  }
}

SceneRenderer::SceneKind SceneRenderer::kind_of(std::uint64_t seed) const {
  Random random(seed, kKind);
  const double draw = random.uniform();
  SceneKind kind;
  kind.is_empty = draw < options_.empty_share;
  kind.has_trunk = !kind.is_empty || random.uniform() < 0.5;
  const bool is_cut = !kind.is_empty && draw < options_.empty_share + options_.cut_share;
  const auto cut_mm = static_cast<float>(random.uniform(-10.0, 60.0));
  if (is_cut) kind.cut_mm = cut_mm;
  Random for_stump(seed, kStump);
  if (kind.is_empty && for_stump.uniform() < options_.stump_share) {
    kind.has_trunk = true;
    kind.stump = sampled_stump(for_stump);
  }
  return kind;
}

std::optional<Grasp> SceneRenderer::grasp_of_scene(const ScenePerson& person, std::uint64_t seed) const {
  Random random(seed, kHeld);
  if (random.uniform() >= options_.held_share || kind_of(seed).is_empty) return std::nullopt;
  return sampled_grasp(*person.skeleton, options_.grasps, random);
}

void SceneRenderer::dress(Drawing& drawing, const Cast& cast, std::span<const Eigen::Vector3f> skin,
                          const Faces& faces) const {
  const std::vector<float>& along_mm = *cast.person.along_mm;
  if (along_mm.empty()) return;
  const ArmSkin arm{skin.first(along_mm.size()), faces, cast.person.rig->person().vertices, along_mm};
  Random for_sleeve(cast.seed, kSleeve);
  if (for_sleeve.uniform() < options_.sleeve_share)
    drawing.mesh.append(mesh_of(sampled_sleeve(for_sleeve), arm), Eigen::Isometry3f::Identity());
  Random for_band(cast.seed, kBand);
  if (for_band.uniform() < options_.band_share)
    drawing.mesh.append(mesh_of(sampled_band(for_band), arm), Eigen::Isometry3f::Identity());
}

void SceneRenderer::add_cut_arm(Drawing& drawing, const std::vector<float>& along_mm, float cut_mm) const {
  const auto is_kept = [&](std::int32_t vertex) { return along_mm.empty() || along_mm[vertex] < cut_mm; };
  Faces kept;
  std::ranges::copy_if(arm_faces_, std::back_inserter(kept),
                       [&](const auto& face) { return std::ranges::all_of(face, is_kept); });
  drawing.add_faces(kept, PixelLabel::person);
}

/// Of the hand, at some moments of the sequence.
std::vector<std::array<Point3, kSupersetSize>> SceneRenderer::landmarks_of_sequence(const Cast& cast) const {
  std::vector<Landmarks> moments;
  for (const PlacedPosture& moment : cast.postures.sequence) {
    moments.push_back(
        cast.person.rig->landmarks(cast.person.rig->pose(moment.posture, moment.camera_from_body)));
  }
  return moments;
}

/// Where the second hand is when the hand is where the scene was made for; one that passes, where it is now.
void SceneRenderer::add_second_hand(Drawing& drawing, const Cast& cast) const {
  Random random(cast.seed, kSecond);
  if (random.uniform() >= options_.second_share) return;
  const double draw = random.uniform();
  const HandMeeting meeting = draw < options_.crossed_share ? HandMeeting::crossed
                              : draw < options_.crossed_share + options_.touching_share
                                  ? HandMeeting::touching
                                  : HandMeeting::near;
  const bool passes = options_.second_pass_frames > 0;
  FirstHand hand{cast.reference(), drawing.actors.landmarks, {}};
  if (passes) hand.moments = landmarks_of_sequence(cast);
  drawing.second = sampled_second_hand(*cast.person.rig, hand, postures_, meeting, passes, random);
  if (!drawing.second) return;
  const double phase = passes ? static_cast<double>(cast.postures.frame % options_.second_pass_frames) /
                                    options_.second_pass_frames
                              : 0.0;
  if (passes) drawing.second = drawing.second->at(phase);
  const std::size_t first = drawing.mesh.vertices.size();
  const auto skin = skin_of(*drawing.second, *cast.person.rig, limb_vertices_, skinning_);
  drawing.mesh.vertices.insert(drawing.mesh.vertices.end(), skin.begin(), skin.end());
  drawing.add_reflected_faces(hand_faces_, PixelLabel::other_hand, first);
  if (passes) drawing.second_places = places_along(drawing.second->path, phase, skin);
}

/// Arms, trunk and clothes.
void SceneRenderer::add_person(Drawing& drawing, const Cast& cast, const SceneKind& kind) const {
  const std::size_t posed =
      drawing.second ? drawing.mesh.vertices.size() - limb_vertices_ : drawing.mesh.vertices.size();
  const bool is_trunk_posed = posed > limb_vertices_;
  if (is_trunk_posed && kind.has_trunk)
    drawing.add_faces(drawing.second ? armless_faces_ : trunk_faces_, PixelLabel::person);
  if (!drawing.has_hand && !kind.stump) return;
  drawing.add_faces(kind.stump ? limb_faces_ : arm_faces_, PixelLabel::person);
  const std::vector<Eigen::Vector3f> skin = drawing.mesh.vertices;  // clothes come into the same mesh
  dress(drawing, cast, skin, limb_faces_);
  if (!drawing.second) return;
  drawing.add_reflected_faces(arm_faces_, PixelLabel::person, posed);
  Faces reflected = limb_faces_;
  for (auto& [a, b, c] : reflected) std::swap(b, c);
  dress(drawing, cast, std::span(skin).subspan(posed), reflected);
}

void SceneRenderer::add_things(Drawing& drawing, const Cast& cast) const {
  drawing.stages = {drawing.held_end};
  const Surroundings around =
      sampled_surroundings(drawing.actors, options_, derived_seed(cast.seed, kAround));
  for (const SceneMesh* part : {&around.room, &around.things, &around.before}) {
    drawing.mesh.append(*part, Eigen::Isometry3f::Identity());
    drawing.stages.push_back(drawing.mesh.faces.size());
  }
  std::ranges::reverse(drawing.stages);
}

SceneRenderer::Drawing SceneRenderer::drawing_of(const Cast& cast, bool may_have_second) const {
  SceneKind kind = kind_of(cast.seed);
  if (cast.person.along_mm->empty()) kind.stump.reset();  // nobody knows where this body's arm is
  const BodyRig& rig = *cast.person.rig;
  const PlacedPosture& now = cast.postures.now;
  const BodyPose pose = rig.pose(now.posture, now.camera_from_body);
  const BodySection section =
      cast.person.culling->visible_section(bone_transforms(rig.person(), pose), cast.camera);
  PosedBody posed = posed_body(rig.person(), pose, static_cast<std::size_t>(section.vertices), skinning_);
  if (kind.stump) {
    const Point3& wrist = posed.landmarks[static_cast<std::size_t>(Landmark::wrist)];
    end_in_stump(posed.vertices, *cast.person.along_mm, *kind.stump, wrist.cast<float>(),
                 elbow_of(rig.person(), pose, posed.landmarks).cast<float>());
  }
  Drawing drawing;
  drawing.landmarks = posed.landmarks;
  drawing.mesh.vertices = posed.vertices;
  drawing.has_hand = !kind.is_empty;
  drawing.actors = actors_of(cast, posed);
  if (drawing.has_hand) drawing.add_faces(hand_faces_, PixelLabel::hand);
  drawing.hand_end = drawing.mesh.faces.size();
  const bool is_alone = kind.is_empty || kind.cut_mm;
  if (may_have_second && !is_alone) add_second_hand(drawing, cast);
  drawing.second_end = drawing.mesh.faces.size();
  if (kind.cut_mm) {
    add_cut_arm(drawing, *cast.person.along_mm, *kind.cut_mm);
  } else {
    add_person(drawing, cast, kind);
  }
  drawing.person_end = drawing.mesh.faces.size();
  if (drawing.has_hand && cast.held != nullptr) add_held(drawing, cast, pose);
  drawing.held_end = drawing.mesh.faces.size();
  drawing.stages = {drawing.held_end};
  if (!kind.cut_mm) {
    // Things keep clear of what is there by now; in a sequence, of what stands still, and of all its places.
    const auto first = drawing.mesh.vertices.begin() + static_cast<std::ptrdiff_t>(posed.vertices.size());
    const auto end = cast.postures.sequence.empty() ? drawing.mesh.vertices.end()
                     : drawing.second && drawing.second_places.empty()
                         ? first + static_cast<std::ptrdiff_t>(limb_vertices_)
                         : first;
    std::vector<Eigen::Vector3f>& points = drawing.actors.points;
    points.insert(points.end(), first, end);
    points.insert(points.end(), drawing.second_places.begin(), drawing.second_places.end());
    add_things(drawing, cast);
  }
  return drawing;
}

/// Skin at all moments of the sequence, so that things that stand still keep clear of it.
SceneActors SceneRenderer::actors_of(const Cast& cast, const PosedBody& posed) const {
  const BodyRig& rig = *cast.person.rig;
  const PlacedPosture& reference = cast.reference();
  const BodyPose pose = rig.pose(reference.posture, reference.camera_from_body);
  SceneActors actors;
  actors.camera = cast.camera;
  actors.up = reference.camera_from_body.linear() * Eigen::Vector3f::UnitY();
  if (cast.postures.sequence.empty()) {
    actors.landmarks = posed.landmarks;
    actors.points = posed.vertices;
  } else {
    actors.landmarks = rig.landmarks(pose);
    for (const PlacedPosture& moment : cast.postures.sequence) {
      const PosedBody then = posed_body(rig.person(), rig.pose(moment.posture, moment.camera_from_body),
                                        limb_vertices_, skinning_);
      actors.points.insert(actors.points.end(), then.vertices.begin(), then.vertices.end());
    }
  }
  actors.hand_points = hand_vertices_;
  actors.elbow = elbow_of(rig.person(), pose, actors.landmarks);
  return actors;
}

void SceneRenderer::add_held(Drawing& drawing, const Cast& cast, const BodyPose& pose) const {
  constexpr float kDeepestMm = 8.0f;  // the balls of thumb and palm are thicker than capsules, and yield
  const RigidTransform hand = camera_from_hand(cast.person.rig->person(), pose);
  if (cast.held->lies_on_hand) {
    constexpr double kLevel = 0.75;
    if (hand.linear().col(2).dot(drawing.actors.up.cast<double>()) < kLevel) return;  // it would fall
  }
  SceneActors skin = drawing.actors;
  skin.points.assign(drawing.mesh.vertices.begin(), drawing.mesh.vertices.end());
  for (const double out_mm : {0.0, 4.0, 8.0}) {  // out of the palm, as flesh pushes it
    RigidTransform shift = RigidTransform::Identity();
    shift.translation().z() = out_mm;
    const RigidTransform camera_from_thing = hand * shift * cast.held->hand_from_thing;
    const PlacedShape thing{cast.held->thing, Eigen::Isometry3f(camera_from_thing.cast<float>())};
    if (!keeps_clear(thing, skin, -kDeepestMm)) continue;
    drawing.mesh.append(thing.shape.mesh, thing.camera_from_shape);
    return;
  }
}

/// What is seen of a drawing's first faces.
struct SceneRenderer::Picture {
  std::vector<Rendering> parts;  ///< hand, second hand, person, things
  Rendering all;
  Image<std::uint8_t> labels;
  double visible_share = 0.0;  ///< of the hand
};

SceneRenderer::Picture SceneRenderer::picture_of(const Drawing& drawing, std::size_t end,
                                                 const Camera& camera) const {
  Picture picture;
  picture.parts = render_groups(drawing.mesh.triangles(),
                                std::array{drawing.hand_end, drawing.second_end, drawing.person_end, end},
                                camera, {.culling = FaceCulling::back_faces});
  picture.all = nearest_of(picture.parts);
  picture.labels = labels_of(picture.all, drawing.mesh.labels);
  picture.visible_share = visible_share_of(picture.parts[0], picture.labels, PixelLabel::hand);
  return picture;
}

std::size_t SceneRenderer::stage_to_show(const Drawing& drawing, const Camera& camera) const {
  std::size_t stage = 0;
  while (stage + 1 < drawing.stages.size() &&
         picture_of(drawing, drawing.stages[stage], camera).visible_share < options_.least_visible) {
    ++stage;
  }
  return stage;
}

ExactFrame SceneRenderer::seen(const Drawing& drawing, const Camera& camera) const {
  Picture picture;
  for (const std::size_t end : drawing.stages) {
    picture = picture_of(drawing, end, camera);
    if (!drawing.has_hand || picture.visible_share >= options_.least_visible) break;
  }
  const std::vector<Rendering>& parts = picture.parts;
  Rendering& all = picture.all;
  Image<std::uint8_t>& labels = picture.labels;
  const double visible_share = picture.visible_share;
  ExactFrame frame;
  frame.truth =
      drawing.has_hand ? in_image(drawing.landmarks, camera) : HandPose::missing(superset_convention());
  const LabelledRendering hand{PixelLabel::hand, &parts[0]};
  const LabelledRendering second{PixelLabel::other_hand, &parts[1]};
  const LabelledRendering person{PixelLabel::person, &parts[2]};
  const LabelledRendering things{PixelLabel::object, &parts[3]};
  if (drawing.has_hand) {
    frame.hands.push_back(
        {HandSide::right, frame.truth,
         occluders_of(drawing.landmarks, frame.truth, parts[0], std::array{second, person, things}),
         visible_share});
  }
  if (drawing.second && seen_pixels(parts[1]) > 0) {
    const HandPose pose = in_image(drawing.second->landmarks, camera);
    frame.hands.push_back(
        {HandSide::left, pose,
         occluders_of(drawing.second->landmarks, pose, parts[1], std::array{hand, person, things}),
         visible_share_of(parts[1], labels, PixelLabel::other_hand)});
  }
  if (needs_angles_) frame.surfaces.cosines = surface_cosines(all, drawing.mesh.triangles(), camera);
  frame.surfaces.depth_mm = std::move(all.depth_mm);
  frame.mask = mask_of_label(labels, PixelLabel::hand);
  frame.labels = std::move(labels);
  return frame;
}

ExactFrame SceneRenderer::render_frame(const ScenePerson& person, const ScenePostures& postures,
                                       const Grasp* held, const Camera& camera, std::uint64_t seed) const {
  const Cast cast{person, postures, held, camera, seed};
  if (!postures.sequence.empty()) return frame_of_sequence(cast);
  const Drawing drawing = drawing_of(cast, true);
  ExactFrame frame = seen(drawing, camera);
  const bool is_hidden = !frame.hands.empty() && frame.hands.front().visible_share < options_.least_visible;
  if (!is_hidden || !drawing.second) return frame;
  return seen(drawing_of(cast, false), camera);
}

/// What hides too much of the hand in the first frame is left out of all.
ExactFrame SceneRenderer::frame_of_sequence(const Cast& cast) const {
  const ScenePostures at_first{cast.reference(), cast.postures.sequence, 0};
  const Cast first{cast.person, at_first, cast.held, cast.camera, cast.seed};
  const std::size_t stage = stage_to_show(drawing_of(first, true), cast.camera);
  Drawing drawing = drawing_of(cast, true);
  drawing.stages = {drawing.stages[stage]};
  return seen(drawing, cast.camera);
}

}  // namespace knuckle
