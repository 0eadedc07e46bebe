// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "knuckle/core/error.h"
#include "knuckle/hand/hand_skeleton.h"

namespace knuckle {
namespace {

/// No point of a hand lies farther from its wrist [mm].
constexpr double kFarthest = 1000.0;
/// No bone of a digit is shorter [mm].
constexpr double kShortest = 1.0;
/// How far an axis's length may lie from 1.
constexpr double kAxisTolerance = 1e-6;
/// Shares of coupled angles are parts of them; beyond this is a fault.
constexpr double kLargestShare = 2.0;

struct Subject {
  std::string_view what;
  std::string_view name;
};

template <class... Values>
[[noreturn]] void fail_of(const Subject& subject, fmt::format_string<Values...> text, Values&&... values) {
  fail("{} '{}': {}", subject.what, subject.name, fmt::format(text, std::forward<Values>(values)...));
}

std::string text_of(const Point3& point) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", point.x(), point.y(), point.z());
}

void check_point(const Subject& subject, const Point3& point, std::string_view field,
                 std::string_view owner) {
  if (!(point.norm() <= kFarthest)) {
    fail_of(subject, "{} of {} is {}, expected a point within {} mm of the wrist", field, owner,
            text_of(point), kFarthest);
  }
}

void check_turn(const Subject& subject, const BoneTurn& turn, std::string_view bone) {
  if (static_cast<int>(turn.angle) >= kHandAngleCount) {
    fail_of(subject, "a turn of {} has angle {}, expected one of {}", bone, static_cast<int>(turn.angle),
            kHandAngleCount);
  }
  if (!(std::abs(turn.axis.norm() - 1.0) <= kAxisTolerance)) {
    fail_of(subject, "the axis of {} of {} is {}, expected a length of 1", name_of(turn.angle), bone,
            text_of(turn.axis));
  }
  if (!(std::abs(turn.share) <= kLargestShare) || turn.share == 0.0) {
    fail_of(subject, "the share of {} of {} is {}, expected one from {} to {}, not 0", name_of(turn.angle),
            bone, turn.share, -kLargestShare, kLargestShare);
  }
}

void check_bone(const Subject& subject, const HandSkeleton& skeleton, int number) {
  const SkeletonBone& bone = skeleton.bones[number];
  const std::string_view name = name_of(static_cast<HandBone>(number));
  const int least = number == 0 ? -1 : 0;
  if (bone.parent < least || bone.parent >= number) {
    fail_of(subject, "the parent of {} is {}, expected {}", name, bone.parent,
            number == 0 ? "-1" : fmt::format("a bone before it, 0 to {}", number - 1));
  }
  check_point(subject, bone.joint_mm, "joint_mm", name);
  if (bone.turns.size() > kMostTurns) {
    fail_of(subject, "{} has {} turns, expected at most {}", name, bone.turns.size(), kMostTurns);
  }
  for (const BoneTurn& turn : bone.turns) check_turn(subject, turn, name);
}

void check_landmark(const Subject& subject, const HandSkeleton& skeleton, int number) {
  const LandmarkPoint& landmark = skeleton.landmarks[number];
  const std::string_view name = name_of(static_cast<Landmark>(number));
  if (static_cast<int>(landmark.bone) >= kHandBoneCount) {
    fail_of(subject, "the bone of {} is {}, expected one of {}", name, static_cast<int>(landmark.bone),
            kHandBoneCount);
  }
  check_point(subject, landmark.straight_mm, "straight_mm", name);
}

void check_lengths(const Subject& subject, const HandSkeleton& skeleton) {
  const auto lengths = digit_lengths_mm(skeleton);
  for (int digit = 0; digit < 5; ++digit) {
    for (int joint = 0; joint < 3; ++joint) {
      if (lengths[digit][joint] >= kShortest) continue;
      fail_of(subject, "{} is {:.4g} mm long, expected at least {} mm", name_of(bone_of_digit(digit, joint)),
              lengths[digit][joint], kShortest);
    }
  }
}

}  // namespace

void check(const HandSkeleton& skeleton, std::string_view what) {
  const Subject subject{what, skeleton.name};
  for (int i = 0; i < kHandBoneCount; ++i) check_bone(subject, skeleton, i);
  for (int i = 0; i < kSupersetSize; ++i) check_landmark(subject, skeleton, i);
  check_lengths(subject, skeleton);
  check(skeleton.limits, fmt::format("{} '{}'", what, skeleton.name));
}

}  // namespace knuckle
