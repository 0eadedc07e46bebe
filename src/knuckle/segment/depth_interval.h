// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "knuckle/core/image.h"

namespace knuckle {

/// The measured pixels with a depth in [near_mm, far_mm] (both rounded to float), row by row: of each its
/// row * width + column.
std::vector<std::int32_t> pixels_between(const Image<float>& depth_mm, double near_mm, double far_mm);

}  // namespace knuckle
