// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/hand_track_fit.h"

#include <utility>

#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/refine/skeleton_pose.h"
#include "knuckle/refine/surface_near.h"

namespace knuckle {
namespace {

constexpr double kPoorFitMm = 10.0;  // a fit from the last pose that is worse is compared with a fresh one
constexpr double kFingerRadPerSecond = 5.0;  // deviation of an angle's speed

/// Fitted from `start` on, and from a fresh one where that ends poorly.
std::optional<SkeletonFit> fit_from(const std::optional<SkeletonPose>& start, const RightHandSight& sight,
                                    const SkeletonFitOptions& options) {
  auto fit = fit_skeleton(adult_skeleton(), sight.targets, options, start, sight.surface);
  if (!start || (fit && fit->rms_mm <= kPoorFitMm)) return fit;
  const auto fresh = fit_skeleton(adult_skeleton(), sight.targets, options, std::nullopt, sight.surface);
  return fresh && (!fit || fresh->energy < fit->energy) ? fresh : fit;
}

}  // namespace

RightHandSight right_hand_sight(const Frame& frame, const HandEstimate& estimate) {
  RightHandSight sight{.targets = targets_of(estimate.pose, frame.camera), .surface = {}};
  sight.surface = surface_near(frame, sight.targets);
  if (estimate.side == HandSide::right) return sight;
  for (LandmarkTarget& target : sight.targets) target.point = in_mirror(target.point, HandSide::left);
  for (Point3& point : sight.surface.points) point = in_mirror(point, HandSide::left);
  sight.surface.depth_mm = [depth = std::move(sight.surface.depth_mm)](const Point3& point) {
    return depth(in_mirror(point, HandSide::left));
  };
  return sight;
}

std::optional<SkeletonFit> fit_track(const HandTrack& track, const RightHandSight& sight, double now_s,
                                     double learn_s, PersonHand& person) {
  SkeletonFitOptions options;
  if (track.pose) {
    options.expected = track.pose->angles;
    options.expected_rad = kFingerRadPerSecond * (now_s - track.seen_s);
  }
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

}  // namespace knuckle
