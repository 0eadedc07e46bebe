// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/skinning.h"

#include <cmath>
#include <cstddef>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// How far a quaternion's norm may lie from 1: some roundings of single precision.
constexpr float kUnitTolerance = 1e-3f;

void check_pose(const Body& body, const BodyPose& pose) {
  if (pose.rotations.size() != body.names.size()) {
    fail("body pose: {} rotations for {} bones", pose.rotations.size(), body.names.size());
  }
  for (std::size_t i = 0; i < pose.rotations.size(); ++i) {
    if (!(std::abs(pose.rotations[i].norm() - 1.0f) <= kUnitTolerance)) {
      fail("body pose: the rotation of bone '{}' is no unit quaternion", body.names[i]);
    }
  }
  if (!pose.camera_from_body.matrix().allFinite()) fail("body pose: camera_from_body is not finite");
}

/// A vertex by its blended transform (linear blend skinning: Lewis et al., "Pose space deformation", 2000,
/// eq. 1).
Eigen::Vector3f skinned_vertex(const Eigen::Vector3f& rest, const std::array<std::int32_t, 4>& bones,
                               const std::array<float, 4>& weights,
                               const std::vector<Eigen::Matrix4f>& transforms) {
  Eigen::Matrix4f blended = weights[0] * transforms[bones[0]];
  for (std::size_t k = 1; k < Body::kBonesAVertex; ++k) {
    if (weights[k] != 0.0f) blended += weights[k] * transforms[bones[k]];
  }
  const Eigen::Vector4f moved =
      blended.col(0) * rest.x() + blended.col(1) * rest.y() + blended.col(2) * rest.z() + blended.col(3);
  return moved.head<3>();
}

}  // namespace

Eigen::Vector3d group_mean(const VertexGroup& group, const std::vector<Eigen::Vector3f>& vertices) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < group.vertices.size(); ++i) {
    sum += group.weights[i] * vertices[group.vertices[i]].cast<double>();
  }
  return sum;
}

void find_joints(ShapedBody& person) {
  const Body& body = *person.body;
  person.joints.clear();
  person.joints.reserve(body.joint_regressor.size());
  for (const VertexGroup& group : body.joint_regressor) {
    person.joints.emplace_back(group_mean(group, person.vertices).cast<float>());
  }
  for (int i = 0; i < kSupersetSize; ++i) {
    person.landmarks[i] = group_mean(body.landmark_regressor[i], person.vertices).cast<float>();
  }
}

ShapedBody shaped_body(const Body& body, std::span<const double> coefficients) {
  if (coefficients.size() != body.shapedirs.size()) {
    fail("body shape: {} coefficients for {} shape directions", coefficients.size(), body.shapedirs.size());
  }
  ShapedBody person;
  person.body = &body;
  person.vertices = body.v_template;
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    const ShapeDirection& direction = body.shapedirs[k];
    const auto coefficient = static_cast<float>(coefficients[k]);
    if (!std::isfinite(coefficient))
      fail("body shape: the coefficient of '{}' is not finite", direction.name);
    if (coefficient == 0.0f) continue;
    for (std::size_t i = 0; i < direction.vertices.size(); ++i) {
      person.vertices[direction.vertices[i]] += coefficient * direction.offsets_mm[i];
    }
  }
  find_joints(person);
  return person;
}

std::vector<Eigen::Matrix4f> bone_transforms(const ShapedBody& person, const BodyPose& pose) {
  const Body& body = *person.body;
  check_pose(body, pose);
  std::vector<Eigen::Matrix4f> transforms(body.names.size());
  for (std::size_t i = 0; i < transforms.size(); ++i) {
    const std::int32_t parent = body.parents[i];
    const Eigen::Matrix4f& above = parent < 0 ? pose.camera_from_body.matrix() : transforms[parent];
    Eigen::Matrix4f turn = Eigen::Matrix4f::Identity();  // x -> rotation (x - head) + head
    const Eigen::Matrix3f rotation = pose.rotations[i].toRotationMatrix();
    turn.topLeftCorner<3, 3>() = rotation;
    turn.topRightCorner<3, 1>() = person.joints[i] - rotation * person.joints[i];
    transforms[i] = above * turn;
  }
  return transforms;
}

PosedBody posed_body(const ShapedBody& person, const BodyPose& pose) {
  return posed_body(person, pose, person.vertices.size());
}

PosedBody posed_body(const ShapedBody& person, const BodyPose& pose, std::size_t vertex_count) {
  const Body& body = *person.body;
  if (vertex_count > person.vertices.size()) {
    fail("body pose: {} vertices asked for, the body has {}", vertex_count, person.vertices.size());
  }
  const std::vector<Eigen::Matrix4f> transforms = bone_transforms(person, pose);
  PosedBody posed;
  posed.vertices.resize(vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i) {
    posed.vertices[i] = skinned_vertex(person.vertices[i], body.weight_bones[i], body.weights[i], transforms);
  }
  for (int i = 0; i < kSupersetSize; ++i) {
    const Eigen::Matrix4f& transform = transforms[body.landmark_bones[i]];
    posed.landmarks[i] = (transform * person.landmarks[i].homogeneous()).head<3>().cast<double>();
  }
  return posed;
}

}  // namespace knuckle
