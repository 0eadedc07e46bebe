// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/motion.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>

#include "knuckle/synth/hand_collision.h"

namespace knuckle {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kHandAttempts = 40;
constexpr int kArmAttempts = 60;
constexpr std::array<std::string_view, 2> kMotions = {"none", "smooth"};

/// How much each of the arm's angles takes part in its sway, in the order of ArmAngles: forearm and wrist
/// most.
constexpr std::array<double, ArmAngles::kCount> kSway = {0.5, 0.5, 0.5, 0.7, 2.0, 1.5, 0.8};

// Parts of a seed's family of streams.
constexpr std::uint64_t kFirstScene = 0;
constexpr std::uint64_t kPoses = 1;

ArmAngles swayed_arm(const ArmAngles& arm, double sway_deg, Random& random) {
  std::vector<double> values = arm.values();
  for (int i = 0; i < ArmAngles::kCount; ++i) {
    const AngleRange& range = arm_ranges()[i];
    values[i] =
        std::clamp(values[i] + kSway[i] * sway_deg * kDegree * random.normal(), range.low, range.high);
  }
  return ArmAngles::from_values(values);
}

ArmAngles interpolated_arm(const ArmAngles& a, const ArmAngles& b, double t) {
  std::vector<double> values = a.values();
  const std::vector<double> others = b.values();
  for (int i = 0; i < ArmAngles::kCount; ++i) values[i] += t * (others[i] - values[i]);
  return ArmAngles::from_values(values);
}

/// Number `index` of the postures that a smooth motion goes through.
Posture pose_of_motion(const BodyRig& rig, const Camera& camera, const PostureOptions& options,
                       const PlacedPosture& first, std::uint64_t seed, std::int64_t index) {
  Random random(derived_seed(seed, kPoses), static_cast<std::uint64_t>(index));
  const HandAngles hand = sampled_free_hand(rig, options.hand, random);
  for (int attempt = 0; attempt < kArmAttempts; ++attempt) {
    const Posture posture{hand, swayed_arm(first.posture.arm, options.motion.sway_deg, random)};
    const BodyPose pose = rig.pose(posture, first.camera_from_body);
    if (violation(rig, pose, camera, options.placement, 0.0) == 0.0) return posture;
  }
  return {hand, first.posture.arm};
}

PlacedPosture smooth_posture(const BodyRig& rig, const Camera& camera, const PostureOptions& options,
                             std::uint64_t seed, std::int64_t index) {
  Random random(derived_seed(seed, kFirstScene));
  PlacementOptions placement = options.placement;
  placement.border_share = 0.0;
  const PlacedPosture first = sampled_placement(rig, HandAngles{}, camera, placement, random);
  const std::int64_t key = index / options.motion.frames_a_pose;
  const double linear =
      static_cast<double>(index % options.motion.frames_a_pose) / options.motion.frames_a_pose;
  const double t = linear * linear * (3.0 - 2.0 * linear);
  const Posture from = pose_of_motion(rig, camera, options, first, seed, key);
  const Posture to = pose_of_motion(rig, camera, options, first, seed, key + 1);
  return {{interpolated(from.hand, to.hand, t), interpolated_arm(from.arm, to.arm, t)},
          first.camera_from_body};
}

}  // namespace

void MotionOptions::visit(OptionVisitor& visitor) {
  visitor.choice("motion", motion, kMotions);
  visitor.integer("frames_a_pose", frames_a_pose, closed(1, 10000));
  visitor.real("sway_deg", sway_deg, closed(0, 90));
}

HandAngles sampled_free_hand(const BodyRig& rig, const HandPoseOptions& options, Random& random) {
  HandAngles best;
  double least = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < kHandAttempts && least > options.penetration_mm; ++attempt) {
    const HandAngles hand = sampled_hand(options, random);
    const BodyPose pose = rig.pose({hand, ArmAngles{}}, Eigen::Isometry3f::Identity());
    const double penetration = worst_penetration_mm(rig.landmarks(pose));
    if (penetration < least) {
      least = penetration;
      best = hand;
    }
  }
  return best;
}

PlacedPosture posture_of_frame(const BodyRig& rig, const Camera& camera, const PostureOptions& options,
                               std::uint64_t seed, std::int64_t index) {
  if (options.motion.is_smooth()) return smooth_posture(rig, camera, options, seed, index);
  Random random(seed, static_cast<std::uint64_t>(index));
  const HandAngles hand = sampled_free_hand(rig, options.hand, random);
  return sampled_placement(rig, hand, camera, options.placement, random);
}

}  // namespace knuckle
