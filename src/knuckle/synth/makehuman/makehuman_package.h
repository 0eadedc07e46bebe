// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace knuckle {

/// MakeHuman's base mesh as its npm package holds it: the whole body with clothes helpers and joint cubes.
struct MakeHumanMesh {
  /// A face of four corners.
  struct Quad {
    std::array<std::int32_t, 4> vertices;
    std::int32_t material;  ///< index into `materials`
  };

  std::string file;                                       ///< that it was read from
  std::vector<Eigen::Vector3f> vertices_mm;               ///< x to the body's left, y up, z to the front
  std::vector<Quad> quads;                                ///< counter-clockwise from outside
  std::vector<std::string> materials;                     ///< "body", "helper-tights", ...
  std::vector<std::array<std::int32_t, 4>> weight_bones;  ///< V x 4, into `bones`
  std::vector<std::array<float, 4>> weights;              ///< V x 4
  std::vector<std::string> bones;                         ///< parents before children
  std::vector<std::int32_t> parents;                      ///< -1 for the root
  std::map<std::string, std::vector<std::int32_t>>
      joint_cubes;  ///< "BONE____head", "BONE____tail": mean = joint
};

/// Reads `public/data/models/human_full_size.json` of the package folder. Throws an Error that names the file
/// where it is missing, damaged, or inconsistent.
MakeHumanMesh read_makehuman_mesh(const std::filesystem::path& package_folder);

/// MakeHuman's morph targets: offsets of all vertices of the mesh, one row per target.
class MakeHumanTargets {
 public:
  /// Reads the names; the rows are read when asked for. Throws an Error that names the file where it is
  /// missing, damaged, or has another size than names x vertices.
  MakeHumanTargets(const std::filesystem::path& package_folder, std::size_t vertex_count);

  /// All names, sorted, without folder prefix and extension: "armslegs/r-hand-scale-incr".
  const std::vector<std::string>& names() const { return names_; }
  /// The target's offsets [mm], one per vertex. Throws an Error where there is no target of that name.
  std::vector<Eigen::Vector3f> offsets_mm(const std::string& name) const;

 private:
  std::filesystem::path offsets_path_;
  std::size_t vertex_count_;
  std::vector<std::string> names_;
};

}  // namespace knuckle
