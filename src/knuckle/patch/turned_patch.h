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

/// A square image turned in its plane by any angle [rad], which takes what is right towards the bottom: each
/// pixel is the nearest one of the image, or `background` where that lies outside.
Image<float> turned_by(const Image<float>& square, double radians, float background);

/// Where a point of the patch lies after the same turn; its depth stays.
PatchPoint turned_by(const PatchPoint& point, double radians);

}  // namespace knuckle
