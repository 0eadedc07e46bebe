// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/adult_skeleton.h"

#include <cstddef>

namespace knuckle {
namespace {

using Eigen::Vector3d;

/// A digit of the straight hand, whose bones lie on one line along y.
struct Digit {
  Point3 base_mm;                    ///< its first joint: the thumb's CMC, a finger's MCP
  std::array<double, 3> lengths_mm;  ///< of its bones, from the palm outwards
  Vector3d flexion_axis;             ///< square to the bones, of any length
};

// Thumb to little.
const std::array<Digit, 5> kDigits = {{
    {{14.8896, 23.2522, 1.1955}, {43.0612, 36.2333, 25.8542}, {0.327811, 0.0, 0.944743}},
    {{20.8007, 88.9733, 3.1663}, {44.7835, 26.1986, 15.8882}, {1.0, 0.0, 0.10}},
    {{0.0, 88.2616, 0.0}, {48.7002, 31.3264, 17.7433}, {1.0, 0.0, 0.02}},
    {{-19.2862, 80.6711, 0.0691}, {44.3408, 30.4115, 17.6067}, {1.0, 0.0, -0.06}},
    {{-30.4622, 67.1564, 3.1663}, {37.6404, 21.5921, 15.4512}, {1.0, 0.0, -0.14}},
}};
const Point3 kPalmCentre(-3.6185, 40.6328, 0.8002);
/// Where ring and little metacarpal turn as the palm arches.
const Point3 kMetacarpalJoint(-18.3673, 36.8797, 1.1491);

SkeletonBone& bone_of(HandSkeleton& skeleton, HandBone bone) {
  return skeleton.bones[static_cast<std::size_t>(bone)];
}

void set_landmark(HandSkeleton& skeleton, Landmark landmark, const Point3& point) {
  skeleton.landmarks[static_cast<std::size_t>(landmark)] = {carrier_of(landmark), point};
}

/// Sets joints and landmarks along a digit, whose first bone hangs on `parent`, and hinges of the last two.
void add_digit(HandSkeleton& skeleton, int number, HandBone parent, HandAngle middle, HandAngle last) {
  const Digit& digit = kDigits[number];
  Point3 point = digit.base_mm;
  int carrier = static_cast<int>(parent);
  for (int joint = 0; joint < 3; ++joint) {
    const HandBone part = bone_of_digit(number, joint);
    bone_of(skeleton, part) = {carrier, point, {}};
    set_landmark(skeleton, landmark_of_digit(number, joint), point);
    carrier = static_cast<int>(part);
    point.y() += digit.lengths_mm[joint];
  }
  set_landmark(skeleton, landmark_of_digit(number, 3), point);
  const Vector3d axis = digit.flexion_axis.normalized();
  bone_of(skeleton, bone_of_digit(number, 1)).turns = {{middle, 1.0, axis}};
  bone_of(skeleton, bone_of_digit(number, 2)).turns = {{last, 1.0, axis}};
}

void add_finger(HandSkeleton& skeleton, int finger, HandBone parent) {
  const FingerAngleNames names = angles_of_finger(finger);
  add_digit(skeleton, finger + 1, parent, names.pip, names.dip);
  const Vector3d axis = kDigits[finger + 1].flexion_axis.normalized();
  // Away from the middle finger is towards the thumb for the index (and the middle finger itself) only.
  const double side = finger <= 1 ? 1.0 : -1.0;
  bone_of(skeleton, bone_of_digit(finger + 1, 0)).turns = {
      {names.mcp, 1.0, axis}, {names.spread, side, Vector3d::UnitY().cross(axis)}};
}

/// The thumb's metacarpal turns about itself while it leaves the plane of the palm, as its saddle joint makes
/// it.
void add_thumb(HandSkeleton& skeleton) {
  add_digit(skeleton, 0, HandBone::palm, HandAngle::thumb_mcp, HandAngle::thumb_ip);
  bone_of(skeleton, HandBone::thumb_metacarpal).turns = {{HandAngle::thumb_radial, -1.0, Vector3d::UnitZ()},
                                                         {HandAngle::thumb_palmar, 1.0, Vector3d::UnitX()},
                                                         {HandAngle::thumb_palmar, -0.55, Vector3d::UnitY()},
                                                         {HandAngle::thumb_twist, -1.0, Vector3d::UnitY()}};
}

void add_palm(HandSkeleton& skeleton) {
  const auto arch = [](double share) {
    return SkeletonBone{static_cast<int>(HandBone::palm),
                        kMetacarpalJoint,
                        {{HandAngle::palm_arch, share, Vector3d::UnitX()}}};
  };
  bone_of(skeleton, HandBone::ring_metacarpal) = arch(0.5);
  bone_of(skeleton, HandBone::little_metacarpal) = arch(1.0);
  set_landmark(skeleton, Landmark::wrist, Point3::Zero());
  set_landmark(skeleton, Landmark::palm, kPalmCentre);
}

HandSkeleton built_adult() {
  HandSkeleton skeleton;
  skeleton.name = "adult";
  skeleton.limits = healthy_limits();
  add_palm(skeleton);
  add_thumb(skeleton);
  add_finger(skeleton, 0, HandBone::palm);
  add_finger(skeleton, 1, HandBone::palm);
  add_finger(skeleton, 2, HandBone::ring_metacarpal);
  add_finger(skeleton, 3, HandBone::little_metacarpal);
  return skeleton;
}

}  // namespace

const HandSkeleton& adult_skeleton() {
  static const HandSkeleton adult = built_adult();
  return adult;
}

}  // namespace knuckle
