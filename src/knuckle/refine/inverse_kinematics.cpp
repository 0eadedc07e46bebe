// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/inverse_kinematics.h"

#include <utility>

#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/refine/skeleton_pose.h"

namespace knuckle {

void InverseKinematicsOptions::visit(OptionVisitor& visitor) {
  visitor.real("noise_mm", noise_mm, open_closed(0, 1000));
  visitor.real("posture_spread", posture_spread, open_closed(0, 100));
  visitor.real("size_spread", size_spread, closed(0, 1));
  visitor.flag("fill", fill);
}

InverseKinematics::InverseKinematics(const InverseKinematicsOptions& options) : options_(options) {
  check_options(options_, "inverse kinematics");
}

RefinedHand InverseKinematics::refine(const Frame& frame, const HandRegion& /*hand*/, HandPose pose) const {
  const SkeletonFitOptions options{.noise_mm = options_.noise_mm,
                                   .posture_spread = options_.posture_spread,
                                   .size_spread = options_.size_spread,
                                   .length_spread = 0.0};
  const auto fit = fit_skeleton(adult_skeleton(), targets_of(pose, frame.camera), options);
  if (!fit) return {std::move(pose)};
  pose = with_skeleton(std::move(pose), adult_skeleton(), fit->pose, frame.camera, options_.fill);
  return {std::move(pose), fit->pose.angles, adult_skeleton().name};
}

}  // namespace knuckle
