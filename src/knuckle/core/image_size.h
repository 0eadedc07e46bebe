// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace knuckle {

/// Width and height of an image [px].
struct ImageSize {
  std::int64_t width = 0;
  std::int64_t height = 0;
  bool operator==(const ImageSize&) const = default;
};

/// Throws an Error that starts with `where` unless both sides are in [1, limits::kImageSide] and the image
/// has at most limits::kImagePixels pixels.
void require_image_size(const ImageSize& size, std::string_view where);

/// Throws an Error that starts with `where` where an image is of another size than its camera.
void require_same_size(const ImageSize& found, const ImageSize& expected, std::string_view where);

}  // namespace knuckle
