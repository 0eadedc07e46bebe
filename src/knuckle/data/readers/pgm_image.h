// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "knuckle/core/image.h"

namespace knuckle {

/// The numbers of a binary PGM image of 16 bits (`P5`), each pair of bytes read as little-endian, which is
/// not what the format says: who calls knows in which order they were written. Throws an Error that starts
/// with `where` where it is not such an image, or has more or fewer bytes than its header says.
Image<std::uint16_t> decode_pgm16(std::string_view bytes, std::string_view where);

/// The same of numbers without a header.
Image<std::uint16_t> decode_plain16(std::string_view bytes, int width, int height, std::string_view where);

}  // namespace knuckle
