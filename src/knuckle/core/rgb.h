// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace knuckle {

/// One 8-bit RGB colour.
struct Rgb {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  bool operator==(const Rgb&) const = default;
};

}  // namespace knuckle
