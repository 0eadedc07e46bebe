// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/pose.h"

#include <algorithm>

namespace knuckle {

HandPose HandPose::missing(const Convention& convention) {
  return {convention, std::vector<ImagePoint>(convention.landmarks.size()), {}};
}

bool HandPose::is_missing() const {
  return std::ranges::all_of(joints, &ImagePoint::is_missing);
}

ImagePoint mean_joint(const HandPose& pose) {
  ImagePoint sum{0.0, 0.0, 0.0};
  int count = 0;
  for (const ImagePoint& joint : pose.joints) {
    if (joint.is_missing()) continue;
    sum = {sum.u + joint.u, sum.v + joint.v, sum.depth_mm + joint.depth_mm};
    ++count;
  }
  if (count == 0) return {};
  return {sum.u / count, sum.v / count, sum.depth_mm / count};
}

HandPose converted(const HandPose& pose, const Convention& target) {
  HandPose result = HandPose::missing(target);
  if (!pose.confidence.empty()) result.confidence.assign(target.landmarks.size(), 0.0f);
  const ConventionMapping mapping = map_convention(pose.convention, target);
  for (std::size_t i = 0; i < result.joints.size(); ++i) {
    const int source = mapping.source_index[i];
    if (source < 0) continue;
    result.joints[i] = pose.joints[source];
    if (!pose.confidence.empty()) result.confidence[i] = pose.confidence[source];
  }
  return result;
}

HandPose mirrored(const HandPose& pose, int width) {
  HandPose result = pose;
  for (ImagePoint& joint : result.joints) joint.u = width - 1 - joint.u;
  return result;
}

}  // namespace knuckle
