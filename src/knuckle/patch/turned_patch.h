// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/image.h"
#include "knuckle/patch/hand_patch.h"

namespace knuckle {

/// A square image turned in its plane by `quarters` quarter turns, which take what is right to the bottom. No
/// pixel is resampled: four quarters are none.
Image<float> turned(const Image<float>& square, int quarters);

/// Where a point of the patch lies after the same turn; its depth stays.
PatchPoint turned(const PatchPoint& point, int quarters);

}  // namespace knuckle
