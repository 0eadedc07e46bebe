// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "knuckle/core/image.h"
#include "knuckle/core/options.h"
#include "knuckle/stream/intrinsics.h"

namespace knuckle {

/// Settings of a `v4l2:` camera.
struct V4l2Options {
  std::string format = "auto";  ///< auto | z16 | inzi | y16; auto: the first of z16 and inzi that there is
  int width = 0;                ///< [0, 16384] [px]; 0: that of ?camera=, else what the device is set to
  int height = 0;               ///< the same
  double rate_hz = 0.0;         ///< frames per second, [0, 1000]; 0: what the device is set to
  double depth_unit_mm = 0.0;   ///< millimetres per count, [0, 1000]; 0: that of the format
  double timeout_s = 5.0;       ///< without a frame, then the camera is lost; [0.1, 3600]
  double wait_s = 0.0;          ///< for a camera that is not there, or lost, to come back; [0, 86400]
  IntrinsicsOptions intrinsics;

  void visit(OptionVisitor& visitor);
};

/// A format of pixels that holds depth. A frame is `images` images of 16-bit little-endian numbers, one after
/// another; the last one is depth, one before it infrared.
struct V4l2DepthFormat {
  std::string_view name;  ///< as in V4l2Options::format
  std::uint32_t code;     ///< V4L2's
  int images;
  double depth_unit_mm;  ///< where nobody says it
};

/// z16, inzi and y16. The kernel's documentation says how each lies in memory, and that the unit is the
/// device's own: 1 mm is that of RealSense D4xx, 1/8 mm that of SR300 (INZI), as they are delivered.
std::span<const V4l2DepthFormat> v4l2_depth_formats();

/// The four letters of a code of V4L2, without blanks at the end; may hold any bytes.
std::string four_letters(std::uint32_t code);

/// How frames lie in memory.
struct V4l2Layout {
  V4l2DepthFormat format{};
  int width = 0;               ///< [px]
  int height = 0;              ///< [px]
  std::size_t line_bytes = 0;  ///< from one row to the next, at least 2 width

  /// Of a whole frame.
  std::size_t frame_bytes() const { return line_bytes * static_cast<std::size_t>(height) * format.images; }
};

/// The images of a frame.
struct V4l2Images {
  Image<float> depth_mm;
  Image<std::uint16_t> infrared;  ///< empty where the format has none
};

/// Takes a frame apart, of which all `layout.frame_bytes()` are there.
V4l2Images decode_v4l2(std::span<const std::uint8_t> bytes, const V4l2Layout& layout, double depth_unit_mm);

}  // namespace knuckle
