// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/hand_track_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/refine/skeleton_pose.h"
#include "knuckle/refine/surface_near.h"

namespace knuckle {
namespace {

constexpr double kPoorFitMm = 10.0;  // a fit from the last pose that is worse is compared with a fresh one
constexpr double kFingerRadPerSecond = 3.0;        // deviation of an angle's speed
constexpr double kFastestTurnRadPerSecond = 25.0;  // a wrist's, and more than that
constexpr double kLargestTurnRad = 1.5;            // within the time of a doubt
constexpr double kLongestDoubtSeconds = 0.3;       // an estimate that says the same for longer is believed
constexpr double kWorseGapMm = 1.0;                // by which the skin may lie worse where a hand is held
constexpr double kElsewhereMm = 75.0;  // a hand that is held is no farther from what was estimated
/// What postures are likely says little of how one changes; said in full in each frame it would be said over
/// and over.
constexpr double kPostureSpread = 1.2;
constexpr double kBoneMm = 4.0;         // of the way from a digit's joint to the next
constexpr double kSurfaceMm = 1.7;      // less than where a frame is seen by itself: the last pose is near
constexpr double kOverlapMm = 2.0;      // of how deep digits run into one another
constexpr double kStandstillMm = 12.0;  // deviation of a landmark from where it was a frame before

/// Fitted from `start` on, and from a fresh one where that ends poorly.
std::optional<SkeletonFit> fit_from(const std::optional<SkeletonPose>& start, const RightHandSight& sight,
                                    const SkeletonFitOptions& options) {
  auto fit = fit_skeleton(adult_skeleton(), sight.targets, options, start, sight.surface);
  if (!start || (fit && fit->rms_mm <= kPoorFitMm)) return fit;
  const auto fresh = fit_skeleton(adult_skeleton(), sight.targets, options, std::nullopt, sight.surface);
  return fresh && (!fit || fresh->energy < fit->energy) ? fresh : fit;
}

/// What is seen of a hand of a side whose landmarks are there, in the camera.
RightHandSight sight_of(const Frame& frame, const LandmarkTargets& targets, HandSide side) {
  RightHandSight sight{.targets = targets, .surface = surface_near(frame, targets)};
  if (side == HandSide::right) return sight;
  for (LandmarkTarget& target : sight.targets) target.point = in_mirror(target.point, HandSide::left);
  for (Point3& point : sight.surface.points) point = in_mirror(point, HandSide::left);
  sight.surface.depth_mm = [depth = std::move(sight.surface.depth_mm)](const Point3& point) {
    return depth(in_mirror(point, HandSide::left));
  };
  return sight;
}

/// What the track's last pose says of the next one.
SkeletonFitOptions options_after(const HandTrack& track, double now_s) {
  SkeletonFitOptions options{.bone_mm = kBoneMm, .surface_mm = kSurfaceMm, .overlap_mm = kOverlapMm};
  if (!track.pose) return options;
  options.posture_spread = kPostureSpread;
  options.expected = track.pose->angles;
  options.expected_rad = kFingerRadPerSecond * (now_s - track.seen_s);
  return options;
}

}  // namespace

RightHandSight right_hand_sight(const Frame& frame, const HandEstimate& estimate) {
  return sight_of(frame, targets_of(estimate.pose, frame.camera), estimate.side);
}

std::optional<SkeletonFit> fit_track(const HandTrack& track, const RightHandSight& sight, double now_s,
                                     double learn_s, PersonHand& person) {
  SkeletonFitOptions options = options_after(track, now_s);
  std::optional<SkeletonPose> start = track.pose;
  if (now_s - track.begun_s <= learn_s) {
    const auto fit = fit_from(start, sight, options);
    if (!fit) return std::nullopt;
    person.learn(fit->pose);
    start = fit->pose;
  }
  person.tell(options);
  return fit_from(start, sight, options);
}

bool turns_too_fast(const HandTrack& track, const SkeletonPose& next, double now_s) {
  const double seconds = now_s - track.agreed_s;
  if (!track.pose || seconds > kLongestDoubtSeconds) return false;
  const Eigen::AngleAxisd turn(track.agreed_turn.transpose() * next.camera_from_hand.linear());
  return turn.angle() > std::min(kFastestTurnRadPerSecond * seconds, kLargestTurnRad);
}

std::optional<SkeletonFit> fit_where_it_was(const HandTrack& track, const SkeletonFit& estimated,
                                            const Frame& frame, double now_s) {
  SkeletonFitOptions options = options_after(track, now_s);
  track.person.tell(options);
  LandmarkTargets targets;
  const auto points = landmarks(adult_skeleton(), *track.pose);
  for (std::size_t i = 0; i < points.size(); ++i) {
    targets[i] = {.point = in_mirror(points[i], track.side()),
                  .weight = std::pow(options.noise_mm / kStandstillMm, 2.0)};
  }
  const RightHandSight sight = sight_of(frame, targets, track.side());
  const auto held = fit_skeleton(adult_skeleton(), sight.targets, options, track.pose, sight.surface);
  const bool is_as_good = held && held->gap_mm <= estimated.gap_mm + kWorseGapMm &&
                          (middle_of(held->pose) - middle_of(estimated.pose)).norm() <= kElsewhereMm;
  return is_as_good ? held : std::nullopt;
}

}  // namespace knuckle
