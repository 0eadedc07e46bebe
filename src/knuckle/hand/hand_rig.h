// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "knuckle/hand/hand_angles.h"
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

/// Bends the right hand of one person by joint angles. Axes come from the person's joints at rest; the
/// fingers, which a mesh at rest shows slightly bent, are first made straight, so that an angle of 0 means
/// what it says.
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

 private:
  /// A chain of three bones, made straight; directions in body axes at rest.
  struct Digit {
    std::array<int, 3> bones{};
    std::array<Eigen::Vector3d, 3> directions;     ///< of the bones at rest
    std::array<Eigen::Quaterniond, 3> straighten;  ///< of each bone relative to its parent
    std::array<Eigen::Vector3d, 3> flexion_axes;   ///< at each joint, before the parent's own turn
    Eigen::Vector3d spread_axis;                   ///< fingers only: towards the thumb
    int metacarpal = -1;                           ///< -1 where the body lacks it
  };

  Digit digit_of(const ShapedBody& person, int number) const;
  Digit finger_of(const ShapedBody& person, int finger) const;
  Digit thumb_of(const ShapedBody& person) const;
  Eigen::Quaterniond thumb_swing(double radial, double palmar) const;
  void add_finger(std::vector<BoneRotation>& result, int finger, const HandAngles& angles) const;
  void add_thumb(std::vector<BoneRotation>& result, const HandAngles& angles) const;

  Eigen::Matrix3d axes_;
  std::array<Digit, 4> fingers_;
  Digit thumb_;
  double thumb_rest_radial_ = 0.0;
  double thumb_rest_palmar_ = 0.0;
};

}  // namespace knuckle
