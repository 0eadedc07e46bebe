// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/skeleton_pose.h"

#include <algorithm>
#include <cmath>

#include "knuckle/camera/projection.h"
#include "knuckle/core/portable_math.h"

namespace knuckle {

LandmarkTargets targets_of(const HandPose& pose, const Camera& camera) {
  const Projection projection(camera);
  LandmarkTargets targets;
  for (std::size_t i = 0; i < pose.joints.size(); ++i) {
    const auto landmark = static_cast<std::size_t>(pose.convention.landmarks[i]);
    if (landmark >= targets.size() || pose.joints[i].is_missing()) continue;
    targets[landmark].point = projection.to_camera(pose.joints[i]);
    targets[landmark].weight = pose.confidence.empty() ? 1.0 : static_cast<double>(pose.confidence[i]);
  }
  return targets;
}

HandPose with_skeleton(HandPose pose, const HandSkeleton& skeleton, const SkeletonPose& fitted,
                       const Camera& camera, bool fill) {
  const Projection projection(camera);
  const auto points = landmarks(skeleton, fitted);
  for (std::size_t i = 0; i < pose.joints.size(); ++i) {
    const auto landmark = static_cast<std::size_t>(pose.convention.landmarks[i]);
    if (landmark >= points.size() || !(points[landmark].z() > 0.0)) continue;
    if (pose.joints[i].is_missing() && !fill) continue;
    pose.joints[i] = projection.to_image(points[landmark]);
  }
  return pose;
}

/// Numbers from manifests/test_scenes.toml and the same rooms without people.
double plausibility_of(const SkeletonFit& fit) {
  constexpr double kForeignGapMm = 9.0;
  constexpr double kUsualSize =
      0.3;  // of the logarithm, either way: from children of six to the largest adults
  constexpr double kSizeSlack = 0.2;
  const double gap = std::isnan(fit.gap_mm) ? 0.0 : fit.gap_mm / kForeignGapMm;
  const double size = std::max(0.0, std::abs(portable_log(fit.pose.size)) - kUsualSize) / kSizeSlack;
  return portable_exp(-gap * gap * gap * gap - size * size);
}

}  // namespace knuckle
