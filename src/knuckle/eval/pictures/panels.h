// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/frame.h"
#include "knuckle/data/readers/image_io.h"

namespace knuckle {

/// Depth, mask and infrared of a frame side by side, each about `height` pixels high: the surroundings of the
/// masked hand (half its size on each side), or the whole frame where it has no mask. What the frame lacks is
/// left out. Infrared is shown with a square root, its 99th percentile white.
Image<Rgb> panels_of(const Frame& frame, int height);

}  // namespace knuckle
