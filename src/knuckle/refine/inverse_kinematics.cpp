// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/inverse_kinematics.h"

#include "knuckle/camera/projection.h"
#include "knuckle/hand/adult_skeleton.h"

namespace knuckle {

void InverseKinematicsOptions::visit(OptionVisitor& visitor) {
  visitor.real("noise_mm", noise_mm, open_closed(0, 1000));
  visitor.real("posture_rad", posture_rad, open_closed(0, 100));
  visitor.real("size_spread", size_spread, closed(0, 1));
  visitor.flag("fill", fill);
}

InverseKinematics::InverseKinematics(const InverseKinematicsOptions& options) : options_(options) {
  check_options(options_, "inverse kinematics");
}

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

HandPose InverseKinematics::refine(const Frame& frame, const HandRegion& /*hand*/, HandPose pose) const {
  const SkeletonFitOptions options{.noise_mm = options_.noise_mm,
                                   .posture_rad = options_.posture_rad,
                                   .size_spread = options_.size_spread};
  const auto fit = fit_skeleton(adult_skeleton(), targets_of(pose, frame.camera), options);
  if (!fit) return pose;
  const Projection projection(frame.camera);
  const auto points = landmarks(adult_skeleton(), fit->pose);
  for (std::size_t i = 0; i < pose.joints.size(); ++i) {
    const auto landmark = static_cast<std::size_t>(pose.convention.landmarks[i]);
    if (landmark >= points.size() || !(points[landmark].z() > 0.0)) continue;
    if (pose.joints[i].is_missing() && !options_.fill) continue;
    pose.joints[i] = projection.to_image(points[landmark]);
  }
  return pose;
}

}  // namespace knuckle
