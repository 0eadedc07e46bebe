// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/hand/arm_rig.h"
#include "knuckle/hand/hand_rig.h"

namespace knuckle {

/// Everything about a person's posture that the library changes.
struct Posture {
  HandAngles hand;
  ArmAngles arm;
};

/// Poses one person by joint angles: right hand and arm; the left arm hangs down.
class BodyRig {
 public:
  /// `person` must outlive this.
  explicit BodyRig(const ShapedBody& person);

  const ShapedBody& person() const { return *person_; }
  BodyPose pose(const Posture& posture, const Eigen::Isometry3f& camera_from_body) const;
  /// The 22 landmarks [mm] in the coordinates that `pose` leads to.
  std::array<Point3, kSupersetSize> landmarks(const BodyPose& pose) const;

 private:
  const ShapedBody* person_;
  HandRig hand_;
  ArmRig arm_;
  std::vector<BoneRotation> left_arm_;
};

}  // namespace knuckle
