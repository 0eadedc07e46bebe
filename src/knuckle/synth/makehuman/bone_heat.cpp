// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/makehuman/bone_heat.h"

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "knuckle/core/error.h"
#include "knuckle/core/nearest_on_segment.h"

namespace knuckle {
namespace {

constexpr double kNearestMm =
    1.0;  // a vertex nearer to a bone is heated as if it were this far: keeps H finite

double distance_to(const BoneSegment& bone, const Eigen::Vector3d& point) {
  const double share = nearest_share(point, bone.head, bone.tail);
  return (point - (bone.head + share * (bone.tail - bone.head))).norm();
}

/// The stiffness matrix of linear elements (cotangent weights) and each vertex's share of area [mm^2].
struct SurfaceOperators {
  Eigen::SparseMatrix<double> stiffness;
  Eigen::VectorXd areas;
};

SurfaceOperators surface_operators(std::span<const Eigen::Vector3d> vertices,
                                   std::span<const std::array<std::int32_t, 3>> faces) {
  const auto count = static_cast<Eigen::Index>(vertices.size());
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& face : faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t apex = face[k];
      const std::int32_t i = face[(k + 1) % 3];
      const std::int32_t j = face[(k + 2) % 3];
      const Eigen::Vector3d a = vertices[i] - vertices[apex];
      const Eigen::Vector3d b = vertices[j] - vertices[apex];
      const double twice_area = a.cross(b).norm();
      areas[apex] += twice_area / 6.0;
      if (twice_area == 0.0) continue;
      const double half_cotangent = 0.5 * a.dot(b) / twice_area;
      entries.emplace_back(i, i, half_cotangent);
      entries.emplace_back(j, j, half_cotangent);
      entries.emplace_back(i, j, -half_cotangent);
      entries.emplace_back(j, i, -half_cotangent);
    }
  }
  Eigen::SparseMatrix<double> stiffness(count, count);
  stiffness.setFromTriplets(entries.begin(), entries.end());
  return {stiffness, areas};
}

}  // namespace

Eigen::MatrixXd bone_heat_weights(std::span<const Eigen::Vector3d> vertices_mm,
                                  std::span<const std::array<std::int32_t, 3>> faces,
                                  std::span<const BoneSegment> bones, double heat) {
  if (bones.empty()) fail("bone heat: no bones");
  if (!(heat > 0.0)) fail("bone heat: heat is {}, expected more than 0", heat);
  SurfaceOperators surface = surface_operators(vertices_mm, faces);
  const auto count = static_cast<Eigen::Index>(vertices_mm.size());
  Eigen::MatrixXd heated = Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(bones.size()));
  for (Eigen::Index i = 0; i < count; ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    Eigen::Index nearest_bone = 0;
    for (std::size_t b = 0; b < bones.size(); ++b) {
      const double distance = distance_to(bones[b], vertices_mm[i]);
      if (distance < nearest) {
        nearest = distance;
        nearest_bone = static_cast<Eigen::Index>(b);
      }
    }
    const double distance = std::max(nearest, kNearestMm);
    const double strength = surface.areas[i] * heat / (distance * distance);
    surface.stiffness.coeffRef(i, i) += strength;
    heated(i, nearest_bone) = strength;
  }
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(surface.stiffness);
  if (solver.info() != Eigen::Success) fail("bone heat: a vertex has no face, or the mesh is degenerate");
  return solver.solve(heated);
}

}  // namespace knuckle
