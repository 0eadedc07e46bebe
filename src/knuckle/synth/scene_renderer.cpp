// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene_renderer.h"

#include <algorithm>
#include <array>
#include <optional>

#include "knuckle/camera/projection.h"
#include "knuckle/synth/render/occlusion.h"
#include "knuckle/synth/render/surface_angle.h"
#include "knuckle/synth/scene/clothes.h"
#include "knuckle/synth/scene/surroundings.h"

namespace knuckle {
namespace {

// Streams of a scene's seed.
constexpr std::uint64_t kKind = 0;
constexpr std::uint64_t kSleeve = 1;
constexpr std::uint64_t kBand = 2;
constexpr std::uint64_t kAround = 3;

/// What a scene is about.
struct SceneKind {
  bool is_empty = false;        ///< there is no hand
  bool has_trunk = true;        ///< an empty scene may still show a face
  std::optional<float> cut_mm;  ///< the arm ends here, along the arm; then there is nothing else
};

SceneKind sampled_kind(const SceneOptions& options, std::uint64_t seed) {
  Random random(seed, kKind);
  const double draw = random.uniform();
  SceneKind kind;
  kind.is_empty = draw < options.empty_share;
  kind.has_trunk = !kind.is_empty || random.uniform() < 0.5;
  const bool is_cut = !kind.is_empty && draw < options.empty_share + options.cut_share;
  const auto cut_mm = static_cast<float>(random.uniform(-10.0, 60.0));
  if (is_cut) kind.cut_mm = cut_mm;
  return kind;
}

/// Whether a vertex hangs on the left wrist by more than half.
std::vector<bool> vertices_of_left_hand(const Body& body) {
  std::vector<bool> hangs_on(body.names.size());
  for (std::size_t i = 0; i < body.names.size(); ++i) {
    const std::int32_t parent = body.parents[i];
    hangs_on[i] = body.names[i] == "wrist.L" || (parent >= 0 && hangs_on[parent]);
  }
  std::vector<bool> is_left(body.v_template.size());
  for (std::size_t v = 0; v < is_left.size(); ++v) {
    float share = 0.0f;
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
      if (hangs_on[body.weight_bones[v][k]]) share += body.weights[v][k];
    }
    is_left[v] = share > 0.5f;
  }
  return is_left;
}

Point3 elbow_of(const ShapedBody& person, const std::vector<Eigen::Matrix4f>& transforms,
                const std::array<Point3, kSupersetSize>& landmarks) {
  const auto found = std::ranges::find(person.body->names, "lowerarm01.R");
  if (found == person.body->names.end()) {
    const Point3& wrist = landmarks[static_cast<std::size_t>(Landmark::wrist)];
    return wrist + 2.0 * (wrist - landmarks[static_cast<std::size_t>(Landmark::middle_mcp)]);
  }
  const auto bone = found - person.body->names.begin();
  return (transforms[bone] * person.joints[bone].homogeneous()).head<3>().cast<double>();
}

HandPose in_image(const std::array<Point3, kSupersetSize>& landmarks, const Camera& camera) {
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

}  // namespace

struct SceneRenderer::Drawing {
  SceneMesh mesh;
  std::size_t hand_end = 0;         ///< faces of the hand come first
  std::size_t person_end = 0;       ///< then those of arm, trunk and clothes
  std::vector<std::size_t> stages;  ///< then things: how many faces there are with all, with less, with none
  std::array<Point3, kSupersetSize> landmarks;
  bool has_hand = true;

  void add_faces(std::span<const std::array<std::int32_t, 3>> faces, PixelLabel label) {
    mesh.faces.insert(mesh.faces.end(), faces.begin(), faces.end());
    mesh.labels.insert(mesh.labels.end(), faces.size(), label);
  }
};

SceneRenderer::SceneRenderer(const Manifest& manifest, const Body& body)
    : options_(manifest.scene),
      needs_angles_(manifest.sensor.needs_angles()),
      skinning_(manifest.body.skinning == "linear" ? Skinning::linear : Skinning::dual_quaternion) {
  const std::size_t limb_end =
      body.sections.size() < 2 ? body.faces.size() : static_cast<std::size_t>(body.sections[1].faces);
  const std::vector<bool> is_left_hand = vertices_of_left_hand(body);
  for (std::size_t f = 0; f < body.faces.size(); ++f) {
    const auto& face = body.faces[f];
    if (f < limb_end) {
      limb_faces_.push_back(face);
      (body.is_hand[f] != 0 ? hand_faces_ : arm_faces_).push_back(face);
    } else if (!is_left_hand[face[0]]) {
      trunk_faces_.push_back(face);
    }
  }
}

void SceneRenderer::dress(Drawing& drawing, const ScenePerson& person, const PosedBody& posed,
                          std::uint64_t seed) const {
  if (person.along_mm->empty()) return;
  const ArmSkin skin{std::span(posed.vertices).first(person.along_mm->size()), limb_faces_,
                     person.rig->person().vertices, *person.along_mm};
  Random for_sleeve(seed, kSleeve);
  if (for_sleeve.uniform() < options_.sleeve_share)
    drawing.mesh.append(mesh_of(sampled_sleeve(for_sleeve), skin), Eigen::Isometry3f::Identity());
  Random for_band(seed, kBand);
  if (for_band.uniform() < options_.band_share)
    drawing.mesh.append(mesh_of(sampled_band(for_band), skin), Eigen::Isometry3f::Identity());
}

void SceneRenderer::add_cut_arm(Drawing& drawing, const std::vector<float>& along_mm, float cut_mm) const {
  const auto is_kept = [&](std::int32_t vertex) { return along_mm.empty() || along_mm[vertex] < cut_mm; };
  for (const auto& face : arm_faces_) {
    if (std::ranges::all_of(face, is_kept)) drawing.add_faces(std::span(&face, 1), PixelLabel::person);
  }
}

SceneRenderer::Drawing SceneRenderer::drawing_of(const ScenePerson& person, const PlacedPosture& placed,
                                                 const Camera& camera, std::uint64_t seed) const {
  const SceneKind kind = sampled_kind(options_, seed);
  const ShapedBody& shaped = person.rig->person();
  const BodyPose pose = person.rig->pose(placed.posture, placed.camera_from_body);
  const std::vector<Eigen::Matrix4f> transforms = bone_transforms(shaped, pose);
  const BodySection section = person.culling->visible_section(transforms, camera);
  const PosedBody posed = posed_body(shaped, pose, static_cast<std::size_t>(section.vertices), skinning_);
  Drawing drawing;
  drawing.landmarks = posed.landmarks;
  drawing.mesh.vertices = posed.vertices;
  drawing.has_hand = !kind.is_empty;
  if (drawing.has_hand) drawing.add_faces(hand_faces_, PixelLabel::hand);
  drawing.hand_end = drawing.mesh.faces.size();
  const bool is_trunk_posed = section.faces > static_cast<std::int32_t>(limb_faces_.size());
  if (kind.cut_mm) {
    add_cut_arm(drawing, *person.along_mm, *kind.cut_mm);
  } else {
    if (drawing.has_hand) drawing.add_faces(arm_faces_, PixelLabel::person);
    if (is_trunk_posed && kind.has_trunk) drawing.add_faces(trunk_faces_, PixelLabel::person);
    if (drawing.has_hand) dress(drawing, person, posed, seed);
  }
  drawing.person_end = drawing.mesh.faces.size();
  drawing.stages = {drawing.person_end};
  if (kind.cut_mm) return drawing;
  const SceneActors actors{camera,
                           posed.landmarks,
                           elbow_of(shaped, transforms, posed.landmarks),
                           placed.camera_from_body.linear() * Eigen::Vector3f::UnitY(),
                           posed.vertices,
                           posed.vertices.size()};
  const Surroundings around = sampled_surroundings(actors, options_, derived_seed(seed, kAround));
  for (const SceneMesh* part : {&around.room, &around.things, &around.before}) {
    drawing.mesh.append(*part, Eigen::Isometry3f::Identity());
    drawing.stages.push_back(drawing.mesh.faces.size());
  }
  std::ranges::reverse(drawing.stages);
  return drawing;
}

ExactFrame SceneRenderer::seen(const Drawing& drawing, const Camera& camera) const {
  std::vector<Rendering> parts;
  Rendering all;
  double visible_share = 0.0;
  Image<std::uint8_t> labels;
  for (const std::size_t end : drawing.stages) {
    parts = render_groups(drawing.mesh.triangles(), std::array{drawing.hand_end, drawing.person_end, end},
                          camera, {.culling = FaceCulling::back_faces});
    all = nearest_of(parts);
    labels = labels_of(all, drawing.mesh.labels);
    const std::int64_t whole = seen_pixels(parts.front());
    const auto visible = std::ranges::count(labels.pixels(), static_cast<std::uint8_t>(PixelLabel::hand));
    visible_share = whole > 0 ? static_cast<double>(visible) / static_cast<double>(whole) : 0.0;
    if (!drawing.has_hand || visible_share >= options_.least_visible) break;
  }
  ExactFrame frame;
  frame.truth =
      drawing.has_hand ? in_image(drawing.landmarks, camera) : HandPose::missing(superset_convention());
  if (drawing.has_hand) {
    const std::array<LabelledRendering, 2> others = {
        {{PixelLabel::person, &parts[1]}, {PixelLabel::object, &parts[2]}}};
    frame.hands.push_back({HandSide::right, frame.truth,
                           occluders_of(drawing.landmarks, frame.truth, parts.front(), others),
                           visible_share});
  }
  if (needs_angles_) frame.surfaces.cosines = surface_cosines(all, drawing.mesh.triangles(), camera);
  frame.surfaces.depth_mm = std::move(all.depth_mm);
  frame.mask = mask_of_label(labels, PixelLabel::hand);
  frame.labels = std::move(labels);
  return frame;
}

ExactFrame SceneRenderer::render_frame(const ScenePerson& person, const PlacedPosture& placed,
                                       const Camera& camera, std::uint64_t seed) const {
  return seen(drawing_of(person, placed, camera, seed), camera);
}

}  // namespace knuckle
