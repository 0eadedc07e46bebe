// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_rig.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "knuckle/core/portable_math.h"
#include "knuckle/hand/rotation_between.h"

namespace knuckle {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Unaligned = Eigen::Quaternion<double, Eigen::DontAlign>;

/// How far the flexion axis of each finger leans out of the plane of the palm, so that bent fingers come
/// together towards the base of the thumb: index to little.
constexpr std::array<double, 4> kAxisLean = {0.10, 0.02, -0.06, -0.14};
/// The thumb's metacarpal turns about itself while it leaves the plane of the palm, as its saddle joint makes
/// it.
constexpr double kThumbTwistPerPalmar = 0.55;
/// The ring metacarpal's part of the little metacarpal's flexion.
constexpr double kRingArch = 0.5;

constexpr std::array<Landmark, 5> kTips = {Landmark::thumb_tip, Landmark::index_tip, Landmark::middle_tip,
                                           Landmark::ring_tip, Landmark::little_tip};

Vector3d joint(const ShapedBody& person, std::string_view bone) {
  return person.joints[person.body->bone(bone)].cast<double>();
}

int bone_or_none(const Body& body, std::string_view name) {
  const auto found = std::ranges::find(body.names, name);
  return found == body.names.end() ? -1 : static_cast<int>(found - body.names.begin());
}

Vector3d across(const Vector3d& vector, const Vector3d& direction) {
  return (vector - vector.dot(direction) * direction).normalized();
}

/// A digit at rest as the mesh shows it, in body axes.
struct DigitAtRest {
  std::array<int, 3> bones{};
  std::array<Vector3d, 3> directions;     ///< of the bones
  std::array<Quaterniond, 3> straighten;  ///< turns of the last two that put all into one line
};

DigitAtRest digit_at_rest(const ShapedBody& person, int number) {
  DigitAtRest digit;
  std::array<Vector3d, 4> points;
  for (int k = 0; k < 3; ++k) {
    digit.bones[k] = person.body->bone(fmt::format("finger{}-{}.R", number, k + 1));
    points[k] = person.joints[digit.bones[k]].cast<double>();
  }
  points[3] = person.landmarks[static_cast<std::size_t>(kTips[number - 1])].cast<double>();
  for (int k = 0; k < 3; ++k) digit.directions[k] = (points[k + 1] - points[k]).normalized();
  for (int k = 1; k < 3; ++k) {
    digit.straighten[k] = rotation_between(digit.directions[k], digit.directions[k - 1]);
  }
  return digit;
}

/// The thumb's metacarpal along the middle finger's turns to where it is at rest: in the plane of the palm by
/// `radial` towards the thumb's side, then out of it by `palmar`.
std::vector<BoneTurn> thumb_swing(const Eigen::Matrix3d& axes) {
  return {{HandAngle::thumb_radial, -1.0, axes.col(2)},
          {HandAngle::thumb_palmar, 1.0, axes.col(0)},
          {HandAngle::thumb_palmar, -kThumbTwistPerPalmar, axes.col(1)}};
}

/// The product of turns, the first leftmost; not one may be missing.
Quaterniond turned(const std::vector<BoneTurn>& turns, const HandAngles& angles) {
  const auto rotation_of = [&](const BoneTurn& turn) {
    return rotation_about(turn.share * angles[turn.angle], turn.axis);
  };
  Quaterniond rotation = rotation_of(turns.front());
  for (std::size_t k = 1; k < turns.size(); ++k) rotation = rotation * rotation_of(turns[k]);
  return rotation;
}

}  // namespace

Eigen::Matrix3d hand_axes(const Vector3d& wrist, const Vector3d& index_mcp, const Vector3d& middle_mcp,
                          const Vector3d& little_mcp) {
  const Vector3d forward = (middle_mcp - wrist).normalized();
  const Vector3d radial = across(index_mcp - little_mcp, forward);
  Eigen::Matrix3d axes;
  axes << radial, forward, radial.cross(forward);
  return axes;
}

Eigen::Matrix3d hand_axes(const std::array<Point3, kSupersetSize>& landmarks) {
  const auto at = [&](Landmark landmark) { return landmarks[static_cast<std::size_t>(landmark)]; };
  return hand_axes(at(Landmark::wrist), at(Landmark::index_mcp), at(Landmark::middle_mcp),
                   at(Landmark::little_mcp));
}

HandRig::HandRig(const ShapedBody& person)
    : axes_(hand_axes(joint(person, "wrist.R"), joint(person, "finger2-1.R"), joint(person, "finger3-1.R"),
                      joint(person, "finger5-1.R"))) {
  add_metacarpal(*person.body, 2, HandBone::ring_metacarpal, kRingArch);
  add_metacarpal(*person.body, 3, HandBone::little_metacarpal, 1.0);
  add_thumb(person);
  for (int finger = 0; finger < 4; ++finger) add_finger(person, finger);
}

void HandRig::add_metacarpal(const Body& body, int finger, HandBone part, double share) {
  const int bone = bone_or_none(body, fmt::format("metacarpal{}.R", finger + 1));
  if (bone < 0) return;
  bones_.push_back({part, bone, {{HandAngle::palm_arch, share, axes_.col(0)}}});
}

void HandRig::add_finger(const ShapedBody& person, int finger) {
  const DigitAtRest digit = digit_at_rest(person, finger + 2);
  const Vector3d radial = axes_.col(0);
  const Vector3d forward = axes_.col(1);
  const Vector3d axis = (radial + kAxisLean[finger] * axes_.col(2)).normalized();
  const Quaterniond straighten = rotation_between(digit.directions[0], forward);
  const Vector3d pip_axis = straighten.inverse() * axis;
  const Vector3d dip_axis = digit.straighten[1].inverse() * pip_axis;
  const FingerAngleNames names = angles_of_finger(finger);
  // Away from the middle finger is towards the thumb for the index (and the middle finger itself) only.
  const double side = finger <= 1 ? 1.0 : -1.0;
  const auto part = [&](int joint) { return bone_of_digit(finger + 1, joint); };
  bones_.push_back({part(0),
                    digit.bones[0],
                    {{names.mcp, 1.0, axis}, {names.spread, side, forward.cross(axis)}},
                    Unaligned(straighten)});
  bones_.push_back({part(1), digit.bones[1], {{names.pip, 1.0, pip_axis}}, Unaligned(digit.straighten[1])});
  bones_.push_back({part(2), digit.bones[2], {{names.dip, 1.0, dip_axis}}, Unaligned(digit.straighten[2])});
}

void HandRig::add_thumb(const ShapedBody& person) {
  const DigitAtRest digit = digit_at_rest(person, 1);
  const Vector3d metacarpal = axes_.transpose() * digit.directions[0];
  HandAngles rest;
  rest[HandAngle::thumb_radial] = portable_atan2(metacarpal.x(), metacarpal.y());
  rest[HandAngle::thumb_palmar] = portable_asin(std::clamp(metacarpal.z(), -1.0, 1.0));
  std::vector<BoneTurn> swing = thumb_swing(axes_);
  const Quaterniond straighten = turned(swing, rest).inverse();
  swing.push_back({HandAngle::thumb_twist, -1.0, axes_.col(1)});
  // A thumb at rest is bent about its own flexion axis; a straight one would not show it, so lean on the
  // palm's.
  constexpr double kPalmarShare = 0.1;
  const Vector3d bend = digit.directions[0].cross(digit.directions[2]);
  const Vector3d axis = across(bend + kPalmarShare * axes_.col(2), digit.directions[0]);
  const Vector3d ip_axis = digit.straighten[1].inverse() * axis;
  bones_.push_back({HandBone::thumb_metacarpal, digit.bones[0], std::move(swing), Unaligned(straighten)});
  bones_.push_back({HandBone::thumb_proximal,
                    digit.bones[1],
                    {{HandAngle::thumb_mcp, 1.0, axis}},
                    Unaligned(digit.straighten[1])});
  bones_.push_back({HandBone::thumb_distal,
                    digit.bones[2],
                    {{HandAngle::thumb_ip, 1.0, ip_axis}},
                    Unaligned(digit.straighten[2])});
}

std::vector<BoneRotation> HandRig::rotations(const HandAngles& angles) const {
  std::vector<BoneRotation> result;
  result.reserve(bones_.size());
  for (const RigBone& bone : bones_) {
    const Quaterniond rotation = turned(bone.turns, angles) * Quaterniond(bone.straighten);
    result.push_back({bone.bone, rotation.normalized().cast<float>()});
  }
  return result;
}

}  // namespace knuckle
