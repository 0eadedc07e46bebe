// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "knuckle/hand/hand_angles.h"
#include "knuckle/hand/hand_bones.h"
#include "knuckle/hand/skinning.h"

namespace knuckle {

/// One entry of BodyPose::rotations.
struct BoneRotation {
  int bone = 0;
  Eigen::Quaternionf rotation = Eigen::Quaternionf::Identity();
};

/// Orthonormal axes of a right hand, as columns: `radial` from the little finger's side to the thumb's,
/// `forward` from the wrist to the middle finger's MCP, `palmar` out of the palm. Right-handed.
Eigen::Matrix3d hand_axes(const Eigen::Vector3d& wrist, const Eigen::Vector3d& index_mcp,
                          const Eigen::Vector3d& middle_mcp, const Eigen::Vector3d& little_mcp);

/// The same of 22 posed landmarks.
Eigen::Matrix3d hand_axes(const std::array<Point3, kSupersetSize>& landmarks);

/// A bone of a body that the hand's angles turn, in body axes at rest: the turns of the straight hand, the
/// first last applied, and before them what makes the mesh's hand straight.
struct RigBone {
  HandBone part = HandBone::palm;
  int bone = 0;                 ///< of the body
  std::vector<BoneTurn> turns;  ///< the first turns what the next have turned
  Eigen::Quaternion<double, Eigen::DontAlign> straighten{1.0, 0.0, 0.0, 0.0};  ///< identity: is straight
};

/// Bends the right hand of one person by joint angles. Axes come from the person's joints at rest; the
/// fingers, which a mesh at rest shows slightly bent, are first made straight, so that an angle of 0 means
/// what it says. The mechanism is written down here once; HandSkeleton is the same without the mesh.
///
/// The body's bones are named as MakeHuman's: finger1-1.R (the thumb's metacarpal) to finger5-3.R, and
/// metacarpal1.R to metacarpal4.R, which a body may lack.
class HandRig {
 public:
  /// Throws an Error where the body lacks a finger's bone.
  explicit HandRig(const ShapedBody& person);

  /// The turns of the bones of the fingers and the palm.
  std::vector<BoneRotation> rotations(const HandAngles& angles) const;

  /// The hand's axes at rest, in body axes.
  const Eigen::Matrix3d& axes_at_rest() const { return axes_; }

  /// The bones that turn.
  const std::vector<RigBone>& bones() const { return bones_; }

 private:
  void add_metacarpal(const Body& body, int finger, HandBone part, double share);
  void add_finger(const ShapedBody& person, int finger);
  void add_thumb(const ShapedBody& person);

  Eigen::Matrix3d axes_;
  std::vector<RigBone> bones_;
};

}  // namespace knuckle
