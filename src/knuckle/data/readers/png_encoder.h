// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "knuckle/core/image.h"
#include "knuckle/core/rgb.h"

namespace knuckle {

/// An image as the bytes of a PNG (ISO/IEC 15948:2004): grey of 16 or 8 bits, or RGB. Packed for speed, as
/// depth is written frame by frame: each pixel minus its left neighbour, runs alone looked for. The same
/// pixels give the same bytes. Throws an Error where the image has no pixels or has more than a million of
/// them a side.
std::vector<std::uint8_t> encode_png(const Image<std::uint16_t>& image);
std::vector<std::uint8_t> encode_png(const Image<std::uint8_t>& image);
std::vector<std::uint8_t> encode_png(const Image<Rgb>& image);

}  // namespace knuckle
