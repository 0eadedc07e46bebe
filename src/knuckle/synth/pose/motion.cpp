// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/motion.h"

#include <algorithm>
#include <array>
#include <limits>

#include "knuckle/core/angle.h"
#include "knuckle/hand/hand_collision.h"
#include "knuckle/synth/pose/gestures.h"

namespace knuckle {
namespace {

constexpr int kHandAttempts = 40;
constexpr int kArmAttempts = 60;

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
                       const PlacedPosture& first, std::uint64_t seed, std::int64_t index,
                       const HandAngles* held_hand) {
  Random random(derived_seed(seed, kPoses), static_cast<std::uint64_t>(index));
  const HandAngles hand = held_hand ? *held_hand : sampled_free_hand(rig, options.hand, random);
  for (int attempt = 0; attempt < kArmAttempts; ++attempt) {
    const Posture posture{hand, swayed_arm(first.posture.arm, options.motion.sway_deg, random)};
    const BodyPose pose = rig.pose(posture, first.camera_from_body);
    if (violation(rig, pose, camera, options.placement, 0.0) == 0.0) return posture;
  }
  return {hand, first.posture.arm};
}

double penetration_mm(const BodyRig& rig, const HandAngles& hand) {
  return worst_penetration_mm(rig.landmarks(rig.pose({hand, ArmAngles{}}, Eigen::Isometry3f::Identity())));
}

/// How hands that are in each other's way pass: half-way they are partly another, more open hand.
struct Detour {
  std::string_view gesture = "relaxed";
  double share = 0.0;
};
constexpr std::array<Detour, 9> kDetours = {{{"relaxed", 0.0},
                                             {"relaxed", 0.25},
                                             {"relaxed", 0.5},
                                             {"relaxed", 0.75},
                                             {"relaxed", 1.0},
                                             {"open", 0.25},
                                             {"open", 0.5},
                                             {"open", 0.75},
                                             {"open", 1.0}}};

/// From one hand to another, angle by angle.
HandAngles on_path(const HandAngles& from, const HandAngles& to, const Detour& detour, double t) {
  const double bump = 16.0 * t * t * (1.0 - t) * (1.0 - t);  // 1 half-way, smooth at both ends
  return interpolated(interpolated(from, to, t), gesture_from_name(detour.gesture).angles,
                      detour.share * bump);
}

/// The least detour on which the digits do not run into one another, or the best.
Detour detour_of_path(const BodyRig& rig, const HandPoseOptions& options, const HandAngles& from,
                      const HandAngles& to) {
  constexpr int kChecks = 12;
  Detour best;
  double least = std::numeric_limits<double>::infinity();
  for (const Detour& detour : kDetours) {
    double worst = 0.0;
    for (int check = 1; check < kChecks && worst < least; ++check) {
      worst = std::max(worst, penetration_mm(rig, on_path(from, to, detour, double{1} / kChecks * check)));
    }
    if (worst < least) {
      least = worst;
      best = detour;
    }
    if (least <= options.penetration_mm) break;
  }
  return best;
}

/// Minimum jerk (Flash and Hogan, "The coordination of arm movements", 1985): from 0 to 1, at rest at both
/// ends, with an acceleration that is continuous and never above 5.78.
double minimum_jerk(double t) {
  return t * t * t * (10.0 + t * (6.0 * t - 15.0));
}

PlacedPosture smooth_posture(const BodyRig& rig, const Camera& camera, const PostureOptions& options,
                             std::uint64_t seed, std::int64_t index, const HandAngles* held_hand) {
  Random random(derived_seed(seed, kFirstScene));
  PlacementOptions placement = options.placement;
  placement.border_share = 0.0;
  const PlacedPosture first =
      sampled_placement(rig, held_hand ? *held_hand : HandAngles{}, camera, placement, random);
  const std::int64_t key = index / options.motion.frames_a_pose;
  const double t =
      minimum_jerk(static_cast<double>(index % options.motion.frames_a_pose) / options.motion.frames_a_pose);
  const Posture from = pose_of_motion(rig, camera, options, first, seed, key, held_hand);
  const Posture to = pose_of_motion(rig, camera, options, first, seed, key + 1, held_hand);
  if (held_hand) return {{*held_hand, interpolated_arm(from.arm, to.arm, t)}, first.camera_from_body};
  const Detour detour = detour_of_path(rig, options.hand, from.hand, to.hand);
  return {{on_path(from.hand, to.hand, detour, t), interpolated_arm(from.arm, to.arm, t)},
          first.camera_from_body};
}

}  // namespace

HandAngles sampled_free_hand(const BodyRig& rig, const HandPoseOptions& options, Random& random) {
  HandAngles best;
  double least = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < kHandAttempts && least > options.penetration_mm; ++attempt) {
    const HandAngles hand = sampled_hand(options, random);
    const double penetration = penetration_mm(rig, hand);
    if (penetration < least) {
      least = penetration;
      best = hand;
    }
  }
  return best;
}

MotionPlace place_in_motion(const MotionOptions& options, std::int64_t index) {
  if (!options.is_smooth()) return {index, 0};
  if (options.sequence_frames == 0) return {0, index};
  return {index / options.sequence_frames, index % options.sequence_frames};
}

PlacedPosture posture_of_frame(const BodyRig& rig, const Camera& camera, const PostureOptions& options,
                               std::uint64_t seed, std::int64_t index, const HandAngles* held_hand) {
  if (options.motion.is_smooth()) {
    const MotionPlace place = place_in_motion(options.motion, index);
    const bool is_one = options.motion.sequence_frames == 0;
    return smooth_posture(rig, camera, options,
                          is_one ? seed : derived_seed(seed, static_cast<std::uint64_t>(place.sequence)),
                          place.frame, held_hand);
  }
  Random random(seed, static_cast<std::uint64_t>(index));
  const HandAngles hand = held_hand ? *held_hand : sampled_free_hand(rig, options.hand, random);
  return sampled_placement(rig, hand, camera, options.placement, random);
}

}  // namespace knuckle
