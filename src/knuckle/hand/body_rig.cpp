// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/body_rig.h"

#include <algorithm>

#include "knuckle/hand/rotation_between.h"

namespace knuckle {
namespace {

/// MakeHuman's arms stand out at rest; people let the other arm hang.
std::vector<BoneRotation> hanging_left_arm(const ShapedBody& person) {
  const std::vector<std::string>& names = person.body->names;
  const auto shoulder = std::ranges::find(names, "upperarm01.L");
  const auto elbow = std::ranges::find(names, "lowerarm01.L");
  if (shoulder == names.end() || elbow == names.end()) return {};
  const auto bone = shoulder - names.begin();
  const Eigen::Vector3f at_rest = person.joints[elbow - names.begin()] - person.joints[bone];
  const Eigen::Vector3d hanging(0.3, -1.0, 0.1);
  return {{static_cast<int>(bone), rotation_between(at_rest.cast<double>(), hanging).cast<float>()}};
}

}  // namespace

BodyRig::BodyRig(const ShapedBody& person)
    : person_(&person), hand_(person), arm_(person), left_arm_(hanging_left_arm(person)) {}

BodyPose BodyRig::pose(const Posture& posture, const Eigen::Isometry3f& camera_from_body) const {
  BodyPose pose;
  pose.rotations.assign(person_->joints.size(), Eigen::Quaternionf::Identity());
  pose.camera_from_body = camera_from_body;
  for (const auto& rotations : {hand_.rotations(posture.hand), arm_.rotations(posture.arm), left_arm_}) {
    for (const auto& [bone, rotation] : rotations) pose.rotations[bone] = rotation;
  }
  return pose;
}

std::array<Point3, kSupersetSize> BodyRig::landmarks(const BodyPose& pose) const {
  return posed_body(*person_, pose, 0).landmarks;
}

}  // namespace knuckle
