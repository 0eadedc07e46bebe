// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/image_size.h"

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"

namespace knuckle {

void require_image_size(const ImageSize& size, std::string_view where) {
  const auto is_side = [](std::int64_t side) { return side >= 1 && side <= limits::kImageSide; };
  if (!is_side(size.width) || !is_side(size.height)) {
    fail("{}: has {} x {} pixels, expected 1 to {} a side", where, size.width, size.height,
         limits::kImageSide);
  }
  if (size.width * size.height > limits::kImagePixels) {
    fail("{}: has {} x {} pixels, expected at most {} in all", where, size.width, size.height,
         limits::kImagePixels);
  }
}

void require_same_size(const ImageSize& found, const ImageSize& expected, std::string_view where) {
  if (found == expected) return;
  fail("{}: is {}x{} pixels, expected {}x{}", where, found.width, found.height, expected.width,
       expected.height);
}

}  // namespace knuckle
