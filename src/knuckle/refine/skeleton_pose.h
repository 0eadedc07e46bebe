// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/camera.h"
#include "knuckle/core/pose.h"
#include "knuckle/hand/skeleton_fit.h"

namespace knuckle {

/// The joints of a pose as targets of a fit, weighted by their confidences (1 where there are none).
LandmarkTargets targets_of(const HandPose& pose, const Camera& camera);

/// The pose with its joints where a fitted skeleton has them; with `fill`, also those that were missing.
/// Those that a skeleton does not have, or that would lie behind the camera, stay.
HandPose with_skeleton(HandPose pose, const HandSkeleton& skeleton, const SkeletonPose& fitted,
                       const Camera& camera, bool fill);

/// How likely what was fitted is a hand, (0, 1]: things that are none have surfaces that no hand has, or look
/// like hands of a size that nobody has (docs/hand-model.md).
double plausibility_of(const SkeletonFit& fit);

}  // namespace knuckle
