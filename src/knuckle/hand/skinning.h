// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/hand/body.h"

namespace knuckle {

/// The weighted mean of a group's vertices.
Eigen::Vector3d group_mean(const VertexGroup& group, const std::vector<Eigen::Vector3f>& vertices);

/// A body with its shape settled: one person. Joints and landmarks follow the morph.
struct ShapedBody {
  const Body* body = nullptr;                            ///< must outlive this
  std::vector<Eigen::Vector3f> vertices;                 ///< V, at rest [mm]
  std::vector<Eigen::Vector3f> joints;                   ///< B bone heads at rest [mm]
  std::array<Eigen::Vector3f, kSupersetSize> landmarks;  ///< at rest [mm]
};

/// Sets joints and landmarks from the vertices, by the body's regressors.
void find_joints(ShapedBody& person);

/// v_template + sum of coefficient x direction; `coefficients` has one per shape direction. Throws an Error
/// where their number is wrong or one is not finite.
ShapedBody shaped_body(const Body& body, std::span<const double> coefficients);

/// How a body stands before a camera.
struct BodyPose {
  /// One a bone: its turn about its own head relative to its parent, in body axes at rest. Identity is the
  /// rest pose.
  std::vector<Eigen::Quaternionf> rotations;
  Eigen::Isometry3f camera_from_body = Eigen::Isometry3f::Identity();  ///< lengths in mm
};

/// A body in camera coordinates.
struct PosedBody {
  std::vector<Eigen::Vector3f> vertices;        ///< V [mm]
  std::array<Point3, kSupersetSize> landmarks;  ///< [mm]
};

/// What each bone does to points of the body at rest: B matrices camera_from_rest. Throws an Error where the
/// pose has another number of bones or a rotation that is not a unit quaternion.
std::vector<Eigen::Matrix4f> bone_transforms(const ShapedBody& person, const BodyPose& pose);

/// How the skin follows several bones.
enum class Skinning : std::uint8_t {
  linear,           ///< the mean of their matrices; thins bent joints
  dual_quaternion,  ///< the mean of their dual quaternions (Kavan et al., "Geometric skinning with
                    ///< approximate dual quaternion blending", 2008), which is a rigid motion again
};

/// Skinning; landmarks move with their bones. Dual quaternions serve the hand, the first of the body's
/// sections, and fade into linear blending where the wrist's skin follows the forearm. Throws as
/// `bone_transforms` does.
PosedBody posed_body(const ShapedBody& person, const BodyPose& pose, Skinning skinning = Skinning::linear);

/// The same, of the first `vertex_count` vertices only: see Body::sections.
PosedBody posed_body(const ShapedBody& person, const BodyPose& pose, std::size_t vertex_count,
                     Skinning skinning = Skinning::linear);

}  // namespace knuckle
