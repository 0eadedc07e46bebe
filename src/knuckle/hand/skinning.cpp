// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/skinning.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

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
      fail("body pose: the rotation of bone '{}' is not a unit quaternion", body.names[i]);
    }
  }
  if (!pose.camera_from_body.matrix().allFinite()) fail("body pose: camera_from_body is not finite");
}

/// Four numbers that are worked on together, lane by lane: with the same bits on every processor.
using Float4 [[gnu::vector_size(16)]] = float;

Float4 lanes(const float* from) {
  Float4 values;
  std::memcpy(&values, from, sizeof(values));
  return values;
}

float dot(Float4 a, Float4 b) {
  const Float4 products = a * b;
  return (products[0] + products[2]) + (products[1] + products[3]);
}

/// A vertex by its blended transform (linear blend skinning: Lewis et al., "Pose space deformation", 2000,
/// eq. 1).
Eigen::Vector3f skinned_vertex(const Eigen::Vector3f& rest, const std::array<std::int32_t, 4>& bones,
                               const std::array<float, 4>& weights,
                               const std::vector<Eigen::Matrix4f>& transforms) {
  std::array<Float4, 4> columns{};
  for (int c = 0; c < 4; ++c) columns[c] = weights[0] * lanes(transforms[bones[0]].col(c).data());
  for (std::size_t k = 1; k < Body::kBonesPerVertex; ++k) {
    if (weights[k] == 0.0f) continue;
    for (int c = 0; c < 4; ++c) columns[c] += weights[k] * lanes(transforms[bones[k]].col(c).data());
  }
  const Float4 moved = columns[0] * rest.x() + columns[1] * rest.y() + columns[2] * rest.z() + columns[3];
  return {moved[0], moved[1], moved[2]};
}

/// A rigid motion: real part the turn, dual part half the shift times the turn; x, y, z, w each.
struct DualQuaternion {
  Float4 real;
  Float4 dual;
};

std::vector<DualQuaternion> dual_quaternions(const std::vector<Eigen::Matrix4f>& transforms) {
  std::vector<DualQuaternion> motions;
  motions.reserve(transforms.size());
  for (const Eigen::Matrix4f& transform : transforms) {
    const Eigen::Matrix3f rotation = transform.topLeftCorner<3, 3>();
    const Eigen::Vector3f shift = transform.topRightCorner<3, 1>();
    const Eigen::Quaternionf turn = Eigen::Quaternionf(rotation).normalized();
    const Eigen::Quaternionf product = Eigen::Quaternionf(0.0f, shift.x(), shift.y(), shift.z()) * turn;
    motions.push_back({lanes(turn.coeffs().data()), 0.5f * lanes(product.coeffs().data())});
  }
  return motions;
}

/// A vertex by its blended motion (Kavan et al. 2008, algorithm 1). Quaternions q and -q are one turn: those
/// are added that lie on the side of the strongest bone's.
Eigen::Vector3f rigidly_skinned_vertex(const Eigen::Vector3f& rest, const std::array<std::int32_t, 4>& bones,
                                       const std::array<float, 4>& weights,
                                       const std::vector<DualQuaternion>& motions) {
  const DualQuaternion& strongest = motions[bones[0]];
  Float4 real = weights[0] * strongest.real;
  Float4 dual = weights[0] * strongest.dual;
  for (std::size_t k = 1; k < Body::kBonesPerVertex; ++k) {
    if (weights[k] == 0.0f) continue;
    const DualQuaternion& motion = motions[bones[k]];
    const float weight = dot(motion.real, strongest.real) < 0.0f ? -weights[k] : weights[k];
    real += weight * motion.real;
    dual += weight * motion.dual;
  }
  const float scale = 1.0f / std::sqrt(dot(real, real));
  real *= scale;
  dual *= scale;
  const Eigen::Vector3f axis(real[0], real[1], real[2]);
  const Eigen::Vector3f moment(dual[0], dual[1], dual[2]);
  const Eigen::Vector3f turned = rest + 2.0f * axis.cross(axis.cross(rest) + real[3] * rest);
  return turned + 2.0f * (real[3] * moment - dual[3] * axis + axis.cross(moment));
}

/// Number of vertices at the beginning that may belong to the hand.
std::size_t hand_vertices(const Body& body) {
  return body.sections.empty() ? body.v_template.size()
                               : static_cast<std::size_t>(body.sections.front().vertices);
}

/// 1 for the bone that carries the wrist and those beyond it, else 0.
std::vector<float> hand_bones(const Body& body) {
  std::vector<float> is_hand(body.parents.size(), 0.0f);
  const auto wrist = static_cast<std::size_t>(body.landmark_bones[static_cast<std::size_t>(Landmark::wrist)]);
  for (std::size_t i = wrist; i < is_hand.size(); ++i) {
    const std::int32_t parent = body.parents[i];
    is_hand[i] = i == wrist || (parent >= 0 && is_hand[parent] == 1.0f) ? 1.0f : 0.0f;
  }
  return is_hand;
}

/// Poses the hand's vertices again, by dual quaternions: wholly where hand bones alone move the skin, not at
/// all where they have half of it or less.
void repose_hand(std::vector<Eigen::Vector3f>& vertices, const ShapedBody& person,
                 const std::vector<Eigen::Matrix4f>& transforms) {
  const Body& body = *person.body;
  const std::vector<float> is_hand = hand_bones(body);
  const std::vector<DualQuaternion> motions = dual_quaternions(transforms);
  for (std::size_t i = 0; i < std::min(vertices.size(), hand_vertices(body)); ++i) {
    const auto& bones = body.weight_bones[i];
    const auto& weights = body.weights[i];
    if (weights[0] == 1.0f) continue;
    float share = 0.0f;
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) share += weights[k] * is_hand[bones[k]];
    const float part = std::clamp(2.0f * share - 1.0f, 0.0f, 1.0f);
    if (part == 0.0f) continue;
    vertices[i] += part * (rigidly_skinned_vertex(person.vertices[i], bones, weights, motions) - vertices[i]);
  }
}

/// `above` after x -> rotation x + moved: the product of two 4 x 4 matrices whose last rows are (0, 0, 0, 1).
Eigen::Matrix4f turned(const Eigen::Matrix4f& above, const Eigen::Matrix3f& rotation,
                       const Eigen::Vector3f& moved) {
  const auto x = above.col(0).head<3>();
  const auto y = above.col(1).head<3>();
  const auto z = above.col(2).head<3>();
  Eigen::Matrix4f result = Eigen::Matrix4f::Identity();
  for (int i = 0; i < 3; ++i)
    result.col(i).head<3>() = (x * rotation(0, i) + y * rotation(1, i)) + z * rotation(2, i);
  result.col(3).head<3>() = (x * moved.x() + y * moved.y()) + (z * moved.z() + above.col(3).head<3>());
  return result;
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
    const Eigen::Matrix3f rotation = pose.rotations[i].toRotationMatrix();
    const Eigen::Vector3f moved = person.joints[i] - rotation * person.joints[i];
    transforms[i] = turned(above, rotation, moved);  // x -> rotation (x - head) + head comes first
  }
  return transforms;
}

PosedBody posed_body(const ShapedBody& person, const BodyPose& pose, Skinning skinning) {
  return posed_body(person, pose, person.vertices.size(), skinning);
}

PosedBody posed_body(const ShapedBody& person, const BodyPose& pose, std::size_t vertex_count,
                     Skinning skinning) {
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
  if (skinning == Skinning::dual_quaternion) repose_hand(posed.vertices, person, transforms);
  for (int i = 0; i < kSupersetSize; ++i) {
    const Eigen::Matrix4f& transform = transforms[body.landmark_bones[i]];
    posed.landmarks[i] = (transform * person.landmarks[i].homogeneous()).head<3>().cast<double>();
  }
  return posed;
}

}  // namespace knuckle
