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

BoneRotation bone_rotation(int bone, const Quaterniond& rotation) {
  return {bone, rotation.normalized().cast<float>()};
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
  for (int finger = 0; finger < 4; ++finger) fingers_[finger] = finger_of(person, finger);
  thumb_ = thumb_of(person);
  const Vector3d metacarpal = axes_.transpose() * thumb_.directions[0];
  thumb_rest_radial_ = portable_atan2(metacarpal.x(), metacarpal.y());
  thumb_rest_palmar_ = portable_asin(std::clamp(metacarpal.z(), -1.0, 1.0));
}

HandRig::Digit HandRig::digit_of(const ShapedBody& person, int number) const {
  Digit digit;
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

HandRig::Digit HandRig::finger_of(const ShapedBody& person, int finger) const {
  Digit digit = digit_of(person, finger + 2);
  const Vector3d radial = axes_.col(0);
  const Vector3d forward = axes_.col(1);
  const Vector3d axis = (radial + kAxisLean[finger] * axes_.col(2)).normalized();
  digit.straighten[0] = rotation_between(digit.directions[0], forward);
  digit.flexion_axes[0] = axis;
  digit.flexion_axes[1] = digit.straighten[0].inverse() * axis;
  digit.flexion_axes[2] = digit.straighten[1].inverse() * digit.flexion_axes[1];
  digit.spread_axis = forward.cross(axis);
  digit.metacarpal = bone_or_none(*person.body, fmt::format("metacarpal{}.R", finger + 1));
  return digit;
}

HandRig::Digit HandRig::thumb_of(const ShapedBody& person) const {
  Digit digit = digit_of(person, 1);
  // A thumb at rest is bent about its own flexion axis; a straight one would not show it, so lean on the
  // palm's.
  constexpr double kPalmarShare = 0.1;
  const Vector3d bend = digit.directions[0].cross(digit.directions[2]);
  const Vector3d axis = across(bend + kPalmarShare * axes_.col(2), digit.directions[0]);
  digit.straighten[0] = Quaterniond::Identity();
  digit.flexion_axes[0] = axis;
  digit.flexion_axes[1] = axis;
  digit.flexion_axes[2] = digit.straighten[1].inverse() * axis;
  return digit;
}

/// Turns `forward` in the plane of the palm by `radial` towards the thumb's side, then out of it by `palmar`.
Quaterniond HandRig::thumb_swing(double radial, double palmar) const {
  const double turn = kThumbTwistPerPalmar * palmar;
  return rotation_about(-radial, axes_.col(2)) * rotation_about(palmar, axes_.col(0)) *
         rotation_about(-turn, axes_.col(1));
}

void HandRig::add_finger(std::vector<BoneRotation>& result, int finger, const HandAngles& angles) const {
  const Digit& digit = fingers_[finger];
  const FingerAngleNames names = angles_of_finger(finger);
  // Away from the middle finger is towards the thumb for the index (and the middle finger itself) only.
  const double spread = (finger <= 1 ? 1.0 : -1.0) * angles[names.spread];
  result.push_back(bone_rotation(digit.bones[0], rotation_about(angles[names.mcp], digit.flexion_axes[0]) *
                                                     rotation_about(spread, digit.spread_axis) *
                                                     digit.straighten[0]));
  result.push_back(bone_rotation(
      digit.bones[1], rotation_about(angles[names.pip], digit.flexion_axes[1]) * digit.straighten[1]));
  result.push_back(bone_rotation(
      digit.bones[2], rotation_about(angles[names.dip], digit.flexion_axes[2]) * digit.straighten[2]));
}

void HandRig::add_thumb(std::vector<BoneRotation>& result, const HandAngles& angles) const {
  const Quaterniond rest = thumb_swing(thumb_rest_radial_, thumb_rest_palmar_);
  const Quaterniond swing = thumb_swing(angles[HandAngle::thumb_radial], angles[HandAngle::thumb_palmar]) *
                            rotation_about(-angles[HandAngle::thumb_twist], axes_.col(1)) * rest.inverse();
  result.push_back(bone_rotation(thumb_.bones[0], swing));
  result.push_back(bone_rotation(
      thumb_.bones[1],
      rotation_about(angles[HandAngle::thumb_mcp], thumb_.flexion_axes[1]) * thumb_.straighten[1]));
  result.push_back(bone_rotation(
      thumb_.bones[2],
      rotation_about(angles[HandAngle::thumb_ip], thumb_.flexion_axes[2]) * thumb_.straighten[2]));
}

std::vector<BoneRotation> HandRig::rotations(const HandAngles& angles) const {
  std::vector<BoneRotation> result;
  for (int finger = 0; finger < 4; ++finger) add_finger(result, finger, angles);
  add_thumb(result, angles);
  const double arch = angles[HandAngle::palm_arch];
  for (const auto& [finger, share] : {std::pair{2, kRingArch}, std::pair{3, 1.0}}) {
    if (fingers_[finger].metacarpal < 0) continue;
    result.push_back(bone_rotation(fingers_[finger].metacarpal, rotation_about(share * arch, axes_.col(0))));
  }
  return result;
}

}  // namespace knuckle
