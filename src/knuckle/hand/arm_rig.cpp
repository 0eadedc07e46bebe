// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/arm_rig.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/angle.h"
#include "knuckle/core/portable_math.h"
#include "knuckle/hand/rotation_between.h"

namespace knuckle {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// The proximal half of the forearm's part of its twist.
constexpr double kProximalTwist = 0.35;

int bone_or_none(const Body& body, std::string_view name) {
  const auto found = std::ranges::find(body.names, name);
  return found == body.names.end() ? -1 : static_cast<int>(found - body.names.begin());
}

Vector3d across(const Vector3d& vector, const Vector3d& direction) {
  return (vector - vector.dot(direction) * direction).normalized();
}

/// Orthonormal: along the upper arm; where the forearm bends to; the elbow's axis.
Eigen::Matrix3d frame_of(const Vector3d& along, const Vector3d& bend) {
  Eigen::Matrix3d frame;
  frame << along, bend, along.cross(bend);
  return frame;
}

}  // namespace

std::vector<double> ArmAngles::values() const {
  return {shoulder_elevation, shoulder_azimuth, humeral_rotation, elbow_flexion,
          supination,         wrist_flexion,    wrist_deviation};
}

ArmAngles ArmAngles::from_values(const std::vector<double>& values) {
  return {values[0], values[1], values[2], values[3], values[4], values[5], values[6]};
}

const std::vector<AngleRange>& arm_ranges() {
  static const std::vector<AngleRange> ranges = {{0, 105 * kDegree},              // shoulder elevation
                                                 {15 * kDegree, 120 * kDegree},   // shoulder azimuth
                                                 {-70 * kDegree, 75 * kDegree},   // humeral rotation
                                                 {5 * kDegree, 140 * kDegree},    // elbow flexion
                                                 {-85 * kDegree, 85 * kDegree},   // supination
                                                 {-70 * kDegree, 75 * kDegree},   // wrist flexion
                                                 {-20 * kDegree, 35 * kDegree}};  // wrist deviation
  return ranges;
}

ArmRig::ArmRig(const ShapedBody& person)
    : upper_arm_(bone_or_none(*person.body, "upperarm01.R")),
      elbow_(bone_or_none(*person.body, "lowerarm01.R")),
      forearm_(bone_or_none(*person.body, "lowerarm02.R")),
      wrist_(bone_or_none(*person.body, "wrist.R")),
      hand_axes_(HandRig(person).axes_at_rest()) {
  if (forearm_ < 0) return;
  const auto joint = [&](int bone) { return Vector3d(person.joints[bone].cast<double>()); };
  const int first = elbow_ >= 0 ? elbow_ : forearm_;
  forearm_direction_ = (joint(wrist_) - joint(first)).normalized();
  if (upper_arm_ < 0 || elbow_ < 0) return;
  const Vector3d along = (joint(elbow_) - joint(upper_arm_)).normalized();
  upper_arm_frame_ = frame_of(along, across(forearm_direction_, along));
  rest_elbow_flexion_ = portable_acos(std::clamp(along.dot(forearm_direction_), -1.0, 1.0));
  // Thumb up at a bent elbow, the palm faces against the elbow's axis; the palm turns up by a positive turn
  // about the forearm.
  const Vector3d neutral = across(-upper_arm_frame_.col(2), forearm_direction_);
  const Vector3d palmar = across(hand_axes_.col(2), forearm_direction_);
  rest_supination_ = portable_atan2(forearm_direction_.dot(neutral.cross(palmar)), neutral.dot(palmar));
}

Quaterniond ArmRig::shoulder_rotation(const ArmAngles& angles) const {
  const double aside = -portable_cos(angles.shoulder_azimuth);  // the right arm's side is -x
  const double forward = portable_sin(angles.shoulder_azimuth);
  const double level = portable_sin(angles.shoulder_elevation);
  const Vector3d along(aside * level, -portable_cos(angles.shoulder_elevation), forward * level);
  const Vector3d bend = rotation_about(angles.humeral_rotation, -along) * across(Vector3d(0, 1, 1), along);
  return Quaterniond(Eigen::Matrix3d(frame_of(along, bend) * upper_arm_frame_.transpose()));
}

std::vector<BoneRotation> ArmRig::rotations(const ArmAngles& angles) const {
  std::vector<BoneRotation> result;
  const auto add = [&](int bone, const Quaterniond& rotation) {
    if (bone >= 0) result.push_back({bone, rotation.normalized().cast<float>()});
  };
  const double twist = angles.supination - rest_supination_;
  if (upper_arm_ >= 0 && elbow_ >= 0) {
    add(upper_arm_, shoulder_rotation(angles));
    add(elbow_, rotation_about(angles.elbow_flexion - rest_elbow_flexion_, upper_arm_frame_.col(2)) *
                    rotation_about(kProximalTwist * twist, forearm_direction_));
    add(forearm_, rotation_about((1.0 - kProximalTwist) * twist, forearm_direction_));
  }
  const Quaterniond straight =
      forearm_ >= 0 ? rotation_between(hand_axes_.col(1), forearm_direction_) : Quaterniond::Identity();
  // The palm's axes, once the wrist is straight.
  const Vector3d radial = straight * hand_axes_.col(0);
  const Vector3d palmar = straight * hand_axes_.col(2);
  add(wrist_, rotation_about(angles.wrist_flexion, radial) * rotation_about(angles.wrist_deviation, palmar) *
                  straight);
  return result;
}

}  // namespace knuckle
