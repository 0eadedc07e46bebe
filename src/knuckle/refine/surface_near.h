// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/frame.h"
#include "knuckle/hand/hand_surface.h"
#include "knuckle/hand/skeleton_fit.h"

namespace knuckle {

/// The points of a frame that lie near landmarks: about `most` of them, evenly spread over the image, within
/// 40 mm of one. With the depth measured at any place, for which the frame has to live as long. Nothing where
/// no landmark is known.
HandSurface surface_near(const Frame& frame, const LandmarkTargets& targets, int most = 250);

}  // namespace knuckle
