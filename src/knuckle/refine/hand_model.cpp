// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/hand_model.h"

#include <optional>
#include <utility>

#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/refine/skeleton_pose.h"
#include "knuckle/refine/surface_near.h"

namespace knuckle {

void HandModelOptions::visit(OptionVisitor& visitor) {
  visitor.real("noise_mm", noise_mm, open_closed(0, 1000));
  visitor.real("bone_mm", bone_mm, closed(0, 1000));
  visitor.real("posture_spread", posture_spread, open_closed(0, 100));
  visitor.real("size_spread", size_spread, closed(0, 1));
  visitor.real("length_spread", length_spread, closed(0, 1));
  visitor.real("surface_mm", surface_mm, open_closed(0, 1000));
  visitor.real("overlap_mm", overlap_mm, closed(0, 1000));
  visitor.flag("fill", fill);
}

HandModel::HandModel(const HandModelOptions& options) : options_(options) {
  check_options(options_, "hand model");
}

RefinedHand HandModel::refine(const Frame& frame, const HandRegion& /*hand*/, HandPose pose) const {
  const SkeletonFitOptions options{.noise_mm = options_.noise_mm,
                                   .bone_mm = options_.bone_mm,
                                   .posture_spread = options_.posture_spread,
                                   .size_spread = options_.size_spread,
                                   .length_spread = options_.length_spread,
                                   .surface_mm = options_.surface_mm,
                                   .overlap_mm = options_.overlap_mm};
  const LandmarkTargets targets = targets_of(pose, frame.camera);
  const auto fit =
      fit_skeleton(adult_skeleton(), targets, options, std::nullopt, surface_near(frame, targets));
  if (!fit) return {std::move(pose)};
  pose = with_skeleton(std::move(pose), adult_skeleton(), fit->pose, frame.camera, options_.fill);
  return {std::move(pose), fit->pose.angles, adult_skeleton().name, plausibility_of(*fit)};
}

}  // namespace knuckle
