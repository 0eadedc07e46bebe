// SPDX-License-Identifier: Apache-2.0
// Filters of masks (pixels 0 or 1) by a square of `side` pixels, [1, 255] and odd, around each pixel. What
// lies outside of the image takes no part.
#pragma once

#include <cstdint>

#include "knuckle/core/image.h"

namespace knuckle {

/// How many of the square's pixels are set.
Image<std::uint16_t> set_in_square(const Image<std::uint8_t>& mask, int side);

/// Set where more than half of side * side pixels are: the median.
Image<std::uint8_t> majority(const Image<std::uint8_t>& mask, int side);
/// Set where any pixel of the square is.
Image<std::uint8_t> dilated(const Image<std::uint8_t>& mask, int side);
/// Set where all pixels of the square are.
Image<std::uint8_t> eroded(const Image<std::uint8_t>& mask, int side);

}  // namespace knuckle
