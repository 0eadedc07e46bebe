// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knuckle/core/image_size.h"

namespace knuckle {

/// The pixels of a PNG, row by row, channels next to each other. Grey of less than 8 bits is stretched to 8,
/// colours of a palette are looked up.
struct PngPixels {
  int width = 0;
  int height = 0;
  int channels = 0;                 ///< 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha
  int bits = 0;                     ///< 8 or 16 of a channel
  std::vector<std::uint8_t> bytes;  ///< 16-bit numbers in this machine's order
};

/// Decodes a PNG (ISO/IEC 15948:2004), its sums and sizes checked first; a file cannot make it take more
/// memory than a thousand times its own size. Throws an Error of one line that starts with `origin` where the
/// bytes are cut short, damaged, not a PNG, or of an image larger than limits::kImageSide and kImagePixels.
/// Where the size that the image must have is known, another is refused before a pixel is decoded.
PngPixels decode_png(std::span<const std::uint8_t> bytes, const std::string& origin,
                     const std::optional<ImageSize>& expected = std::nullopt);

}  // namespace knuckle
