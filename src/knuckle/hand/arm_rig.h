// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "knuckle/hand/hand_rig.h"

namespace knuckle {

/// The angles of a right arm [rad].
struct ArmAngles {
  double shoulder_elevation = 0.0;  ///< of the upper arm: 0 hangs down, pi / 2 is level
  double shoulder_azimuth = 0.0;    ///< where it is raised to: 0 aside, pi / 2 forward
  double humeral_rotation = 0.0;    ///< inwards; at 0 a bent forearm points forward and up
  double elbow_flexion = 0.0;       ///< 0 straight
  double supination = 0.0;          ///< of the forearm; 0 with the thumb up, pi / 2 with the palm up
  double wrist_flexion = 0.0;       ///< towards the palm
  double wrist_deviation = 0.0;     ///< towards the little finger

  static constexpr int kCount = 7;
  /// All angles in the order above.
  std::vector<double> values() const;
  static ArmAngles from_values(const std::vector<double>& values);
  bool operator==(const ArmAngles&) const = default;
};

/// How far each of them goes, in the order of ArmAngles (healthy adults; American Academy of Orthopaedic
/// Surgeons, "Joint motion", 1965; the shoulder's range is what an interaction in front of a camera asks
/// for).
const std::vector<AngleRange>& arm_ranges();

/// Poses the right arm of one person: MakeHuman's bones upperarm01.R, lowerarm01.R, lowerarm02.R and wrist.R.
/// A body that lacks one of them is a hand alone: then nothing but what it has is turned.
class ArmRig {
 public:
  explicit ArmRig(const ShapedBody& person);

  std::vector<BoneRotation> rotations(const ArmAngles& angles) const;

 private:
  Eigen::Quaterniond shoulder_rotation(const ArmAngles& angles) const;

  int upper_arm_;
  int elbow_;
  int forearm_;
  int wrist_;
  Eigen::Matrix3d hand_axes_;
  Eigen::Matrix3d upper_arm_frame_ =
      Eigen::Matrix3d::Identity();  ///< at rest: along, bend direction, elbow's axis
  Eigen::Vector3d forearm_direction_ = Eigen::Vector3d::UnitZ();  ///< at rest, elbow to wrist
  double rest_elbow_flexion_ = 0.0;
  double rest_supination_ = 0.0;
};

}  // namespace knuckle
