// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/hand/hand_collision.h"

namespace knuckle {

/// The skin of a hand in the camera, as capsules [mm].
using HandSkin = std::vector<HandCapsule>;

/// How far a point is outside of a hand's skin; negative: inside [mm]; infinite where `skin` is empty.
double distance_to_skin_mm(const Point3& point, const HandSkin& skin);

/// The frame as it would be without `others`: what is measured within `reach_mm` of the skin of one of them,
/// and nearer to it than to `own`, is not measured any more. So of two hands that pass or touch, each can be
/// looked for as if it were alone. `own` may be empty. Thread-safe.
Frame without_hands(const Frame& frame, std::span<const HandSkin> others, const HandSkin& own,
                    double reach_mm);

}  // namespace knuckle
