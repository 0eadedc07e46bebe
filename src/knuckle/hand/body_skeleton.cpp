// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/body_skeleton.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/hand/hand_rig.h"

namespace knuckle {
namespace {

/// A body whose hand is made straight: what each bone does to points at rest, in body axes.
class StraightHand {
 public:
  StraightHand(const ShapedBody& person, const HandRig& rig)
      : person_(person), rig_(rig), wrist_(person.body->bone("wrist.R")) {
    transforms_.resize(person.joints.size(), RigidTransform::Identity());
    for (std::size_t i = 0; i < transforms_.size(); ++i) {
      const std::int32_t parent = person.body->parents[i];
      if (parent >= 0) transforms_[i] = transforms_[parent];
      const RigBone* turned = rig_bone(static_cast<int>(i));
      if (turned == nullptr) continue;
      const Point3 joint = person.joints[i].cast<double>();
      transforms_[i] = transforms_[i] * Eigen::Translation3d(joint) * Eigen::Quaterniond(turned->straighten) *
                       Eigen::Translation3d(-joint);
    }
  }

  /// The part of the hand that a bone of the body, -1 for none, belongs to; `what` is carried by it.
  HandBone part_of(int bone, std::string_view what) const {
    for (; bone >= 0; bone = person_.body->parents[bone]) {
      if (bone == wrist_) return HandBone::palm;
      if (const RigBone* turned = rig_bone(bone)) return turned->part;
    }
    fail("hand skeleton: {} does not hang on the body's bone 'wrist.R'", what);
  }

  const RigidTransform& of(int bone) const { return transforms_[bone]; }

 private:
  const RigBone* rig_bone(int bone) const {
    const auto found = std::ranges::find(rig_.bones(), bone, &RigBone::bone);
    return found == rig_.bones().end() ? nullptr : &*found;
  }

  const ShapedBody& person_;
  const HandRig& rig_;
  int wrist_;
  std::vector<RigidTransform> transforms_;
};

/// A right hand's axes at rest; the wrist's joint is the origin.
RigidTransform body_from_hand(const ShapedBody& person, const HandRig& rig) {
  RigidTransform result = RigidTransform::Identity();
  result.linear() = rig.axes_at_rest();
  result.translation() = person.joints[person.body->bone("wrist.R")].cast<double>();
  return result;
}

/// A bone of the body that turns, as one of the straight hand.
SkeletonBone straight_bone(const RigBone& rig_bone, const ShapedBody& person, const StraightHand& straight,
                           const RigidTransform& hand_from_body) {
  const int carrier = person.body->parents[rig_bone.bone];
  SkeletonBone bone;
  bone.parent = static_cast<int>(straight.part_of(carrier, name_of(rig_bone.part)));
  const RigidTransform hand_from_rest = hand_from_body * straight.of(carrier);
  bone.joint_mm = hand_from_rest * Point3(person.joints[rig_bone.bone].cast<double>());
  for (BoneTurn turn : rig_bone.turns) {
    turn.axis = hand_from_rest.linear() * turn.axis;
    bone.turns.push_back(turn);
  }
  return bone;
}

}  // namespace

RigidTransform body_from_hand(const ShapedBody& person) {
  return body_from_hand(person, HandRig(person));
}

RigidTransform camera_from_hand(const ShapedBody& person, const BodyPose& pose) {
  const Eigen::Matrix4d transform =
      bone_transforms(person, pose)[person.body->bone("wrist.R")].cast<double>();
  RigidTransform camera_from_body;
  camera_from_body.matrix() = transform;
  return camera_from_body * body_from_hand(person);
}

HandSkeleton skeleton_of(const ShapedBody& person, std::string name) {
  const HandRig rig(person);
  const StraightHand straight(person, rig);
  const RigidTransform hand_from_body = body_from_hand(person, rig).inverse();
  HandSkeleton skeleton;
  skeleton.name = std::move(name);
  skeleton.limits = healthy_limits();
  // What a body lacks is fixed to the palm.
  for (int i = 1; i < kHandBoneCount; ++i) skeleton.bones[i].parent = static_cast<int>(HandBone::palm);
  for (const RigBone& bone : rig.bones()) {
    skeleton.bones[static_cast<std::size_t>(bone.part)] =
        straight_bone(bone, person, straight, hand_from_body);
  }
  for (int i = 0; i < kSupersetSize; ++i) {
    const int carrier = person.body->landmark_bones[i];
    skeleton.landmarks[i] = {
        straight.part_of(carrier, name_of(static_cast<Landmark>(i))),
        hand_from_body * straight.of(carrier) * Point3(person.landmarks[i].cast<double>())};
  }
  return skeleton;
}

}  // namespace knuckle
