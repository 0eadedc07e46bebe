// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "knuckle/core/image.h"

namespace knuckle {

/// A `sensor_msgs/Image`, however it was serialised. Its pixels belong to somebody else.
struct RosImage {
  double stamp_s = 0.0;  ///< of its header [s]; 0 where the camera's driver gave none
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string encoding;  ///< as in "16UC1"
  bool is_big_endian = false;
  std::uint32_t step = 0;                ///< from row to row [bytes]
  std::span<const std::uint8_t> pixels;  ///< height x step
};

/// Whether that encoding may hold depth: 16UC1 or mono16 (counts), 32FC1 (metres).
bool is_depth_encoding(std::string_view encoding);

/// Depth [mm]. A count is `unit_mm` millimetres; a metre is 1000. Counts of 0, NaN, infinity and what is not
/// above 0 are no measurement. Throws an Error that starts with `where` where the encoding is no depth, the
/// sizes do not fit together or exceed the limits; before memory is taken.
Image<float> depth_mm_of(const RosImage& image, double unit_mm, std::string_view where);

/// Whether that encoding may hold infrared: mono8, 8UC1, mono16 or 16UC1.
bool is_infrared_encoding(std::string_view encoding);

/// Infrared, counts as they are. Throws an Error that starts with `where` as `depth_mm_of` does.
Image<std::uint16_t> infrared_of(const RosImage& image, std::string_view where);

}  // namespace knuckle
