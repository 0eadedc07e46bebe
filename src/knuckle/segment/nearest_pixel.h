// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "knuckle/core/image.h"

namespace knuckle {

/// A pixel and its depth after the median filter.
struct NearestPixel {
  int column = 0;
  int row = 0;
  float depth_mm = 0.0f;
};

/// The depth of a pixel after a 5x5 median filter over the measured pixels of its window (of an even number
/// the lower middle one, so that it is a depth that was measured). 0 where fewer than 13 of the 25 are
/// measured: there, a few stray pixels would be their own median.
float median_depth(const Image<float>& depth_mm, int column, int row);

/// The pixel nearest to the sensor after that filter: where mean shift starts. Same depth as filtering the
/// whole image and taking the minimum; where several pixels have it, one of them, always the same. Nothing
/// where no window holds enough measurements.
std::optional<NearestPixel> nearest_pixel(const Image<float>& depth_mm);

}  // namespace knuckle
