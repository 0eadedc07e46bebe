// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/data/frame_source.h"

namespace knuckle {

/// A unit in which 16 bits hold the depth of all frames of a set [mm]: the coarsest in which each keeps its
/// bits (`exact_depth_unit_mm`); else 0.1 mm, which reaches to 6.5 m, or 1 mm where something is farther.
/// Reads every frame, on all cores. Throws an Error where one cannot be read.
double set_depth_unit_mm(const FrameSource& source);

}  // namespace knuckle
