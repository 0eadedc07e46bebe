// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/makehuman/makehuman_package.h"

#include <algorithm>
#include <bit>
#include <fstream>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/text_file.h"

namespace knuckle {
namespace {

using nlohmann::json;

constexpr float kMmPerUnit = 100.0f;      // the mesh is in decimetres
constexpr float kMmPerTargetStep = 0.1f;  // targets are in thousandths of a decimetre
constexpr int kFaceStride = 10;           // flags, 4 vertices, material, 4 texture coordinates
constexpr int kQuadWithTexture =
    1 | 2 | 8;  // three.js JSON 3.1: quad, material, texture coordinates a corner
constexpr std::string_view kHeadSuffix = "____head";

json read_json(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) {
    fail("{}: the file is missing; scripts/fetch_makehuman.sh fetches MakeHuman's data", path.string());
  }
  try {
    return json::parse(read_text_file(path));
  } catch (const json::exception&) {
    fail("{}: no JSON, or cut short", path.string());
  }
}

/// JSON's numbers may have any size, and fractions.
bool is_whole_number(const json& value) {
  using Limits = std::numeric_limits<std::int32_t>;
  return value.is_number_integer() && value.get<double>() >= Limits::min() &&
         value.get<double>() <= Limits::max();
}

std::int32_t whole_number(const json& value) {
  if (!is_whole_number(value))
    fail("{} stands where a number of a bone, face or vertex belongs", value.dump());
  return value.get<std::int32_t>();
}

std::vector<std::int32_t> whole_numbers(const json& values) {
  if (!values.is_array()) fail("numbers of bones, faces or vertices are no list");
  std::vector<std::int32_t> numbers;
  for (const json& value : values) numbers.push_back(whole_number(value));
  return numbers;
}

/// "wrist.R____head" -> "wrist.R": the package makes two nodes of each bone.
std::string bone_of_node(const std::string& node) {
  return node.ends_with(kHeadSuffix) ? node.substr(0, node.size() - kHeadSuffix.size()) : node;
}

/// Bones from the package's list of nodes, and the bone of each node.
std::vector<std::int32_t> read_bones(const json& nodes, MakeHumanMesh& mesh) {
  std::vector<std::int32_t> bone_of;
  for (const json& node : nodes) {
    const std::string name = bone_of_node(node.at("name").get<std::string>());
    const std::int32_t parent_node = whole_number(node.at("parent"));
    if (parent_node >= static_cast<int>(bone_of.size())) fail("bone '{}' comes before its parent", name);
    const std::int32_t parent = parent_node < 0 ? -1 : bone_of[parent_node];
    if (parent >= 0 && mesh.bones[parent] == name) {
      bone_of.push_back(parent);
      continue;
    }
    bone_of.push_back(static_cast<std::int32_t>(mesh.bones.size()));
    mesh.bones.push_back(name);
    mesh.parents.push_back(parent);
  }
  return bone_of;
}

void read_vertices(const json& document, MakeHumanMesh& mesh) {
  const auto numbers = document.at("vertices").get<std::vector<float>>();
  if (numbers.empty() || numbers.size() % 3 != 0) fail("'vertices' has {} numbers", numbers.size());
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    mesh.vertices_mm.emplace_back(kMmPerUnit * Eigen::Vector3f(numbers[i], numbers[i + 1], numbers[i + 2]));
  }
}

void read_quads(const json& document, MakeHumanMesh& mesh) {
  for (const json& material : document.at("materials")) mesh.materials.push_back(material.at("DbgName"));
  const auto numbers = whole_numbers(document.at("faces"));
  if (numbers.size() % kFaceStride != 0) fail("'faces' has {} numbers", numbers.size());
  for (std::size_t i = 0; i < numbers.size(); i += kFaceStride) {
    if (numbers[i] != kQuadWithTexture)
      fail("a face has the flags {}, expected {}", numbers[i], kQuadWithTexture);
    MakeHumanMesh::Quad quad{{numbers[i + 1], numbers[i + 2], numbers[i + 3], numbers[i + 4]},
                             numbers[i + 5]};
    const auto [low, high] = std::ranges::minmax(quad.vertices);
    if (low < 0 || high >= std::ssize(mesh.vertices_mm)) fail("a face names vertex {}", low < 0 ? low : high);
    if (quad.material < 0 || quad.material >= std::ssize(mesh.materials))
      fail("a face names material {}", quad.material);
    mesh.quads.push_back(quad);
  }
}

void read_weights(const json& document, const std::vector<std::int32_t>& bone_of_node, MakeHumanMesh& mesh) {
  const auto weights = document.at("skinWeights").get<std::vector<float>>();
  const auto nodes = whole_numbers(document.at("skinIndices"));
  const std::size_t expected = 4 * mesh.vertices_mm.size();
  if (document.at("influencesPerVertex") != 4 || weights.size() != expected || nodes.size() != expected) {
    fail("expected 4 skin weights a vertex");
  }
  for (std::size_t i = 0; i < expected; i += 4) {
    std::array<std::int32_t, 4> bones{};
    for (std::size_t k = 0; k < 4; ++k) {
      if (nodes[i + k] < 0 || nodes[i + k] >= std::ssize(bone_of_node))
        fail("a weight names bone {}", nodes[i + k]);
      bones[k] = bone_of_node[nodes[i + k]];
    }
    mesh.weight_bones.push_back(bones);
    mesh.weights.push_back({weights[i], weights[i + 1], weights[i + 2], weights[i + 3]});
  }
}

void read_joint_cubes(const json& document, MakeHumanMesh& mesh) {
  for (const auto& [name, vertices] : document.at("metadata").at("joint_pos_idxs").items()) {
    const auto cube = whole_numbers(vertices);
    if (cube.empty()) fail("joint '{}' has no vertices", name);
    const auto [low, high] = std::ranges::minmax(cube);
    if (low < 0 || high >= std::ssize(mesh.vertices_mm))
      fail("joint '{}' names vertex {}", name, low < 0 ? low : high);
    mesh.joint_cubes[name] = cube;
  }
}

std::string target_name(std::string key) {
  constexpr std::string_view kPrefix = "data/targets/";
  constexpr std::string_view kExtension = ".target";
  if (key.starts_with(kPrefix)) key.erase(0, kPrefix.size());
  if (key.ends_with(kExtension)) key.erase(key.size() - kExtension.size());
  return key;
}

}  // namespace

MakeHumanMesh read_makehuman_mesh(const std::filesystem::path& package_folder) {
  const std::filesystem::path path = package_folder / "public/data/models/human_full_size.json";
  const json document = read_json(path);
  MakeHumanMesh mesh;
  mesh.file = path.string();
  try {
    read_vertices(document, mesh);
    read_quads(document, mesh);
    read_weights(document, read_bones(document.at("bones"), mesh), mesh);
    read_joint_cubes(document, mesh);
  } catch (const json::exception& error) {
    fail("{}: not MakeHuman's mesh: {}", path.string(), error.what());
  } catch (const Error& error) {
    fail("{}: {}", path.string(), error.what());
  }
  return mesh;
}

MakeHumanTargets::MakeHumanTargets(const std::filesystem::path& package_folder, std::size_t vertex_count)
    : offsets_path_(package_folder / "public/data/targets/targets.bin"), vertex_count_(vertex_count) {
  const std::filesystem::path list_path = package_folder / "src/json/targets/target-list.json";
  const json list = read_json(list_path);
  if (!list.is_object() || !list.contains("targets") || !list["targets"].is_object()) {
    fail("{}: expected an object 'targets'", list_path.string());
  }
  std::vector<std::string> keys;
  for (const auto& [key, parts] : list["targets"].items()) keys.push_back(key);
  std::ranges::sort(keys);  // the rows follow the order of the keys, extension included
  for (const std::string& key : keys) names_.push_back(target_name(key));

  std::error_code code;
  const auto size = std::filesystem::file_size(offsets_path_, code);
  if (code) {
    fail("{}: the file is missing; scripts/fetch_makehuman.sh fetches MakeHuman's data",
         offsets_path_.string());
  }
  const std::uintmax_t expected = names_.size() * vertex_count * 3 * sizeof(std::int16_t);
  if (size != expected) fail("{}: has {} bytes, expected {}", offsets_path_.string(), size, expected);
}

std::vector<Eigen::Vector3f> MakeHumanTargets::offsets_mm(const std::string& name) const {
  static_assert(std::endian::native == std::endian::little, "targets.bin is little-endian");
  const auto found = std::ranges::find(names_, name);
  if (found == names_.end()) fail("{}: there is no target '{}'", offsets_path_.string(), name);
  const std::size_t row_bytes = vertex_count_ * 3 * sizeof(std::int16_t);
  std::vector<std::int16_t> steps(vertex_count_ * 3);
  std::ifstream file(offsets_path_, std::ios::binary);
  file.seekg(static_cast<std::streamoff>((found - names_.begin()) * row_bytes));
  file.read(reinterpret_cast<char*>(steps.data()), static_cast<std::streamsize>(row_bytes));
  if (!file) fail("{}: cannot be read", offsets_path_.string());
  std::vector<Eigen::Vector3f> offsets(vertex_count_);
  for (std::size_t i = 0; i < vertex_count_; ++i) {
    offsets[i] = kMmPerTargetStep * Eigen::Vector3f(steps[3 * i], steps[3 * i + 1], steps[3 * i + 2]);
  }
  return offsets;
}

}  // namespace knuckle
