// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "knuckle/stream/v4l2_device.h"
#include "knuckle/stream/v4l2_format.h"

namespace knuckle {

/// Codes of all pixel formats that a device offers.
std::vector<std::uint32_t> offered_formats(const V4l2Device& device);

/// Those of them that hold depth, or may do so (y16).
std::vector<V4l2DepthFormat> offered_depth_formats(const V4l2Device& device);

/// What a device was set to.
struct V4l2Mode {
  V4l2Layout layout;
  double rate_hz = 0.0;  ///< frames per second; 0: it does not say

  std::string text() const;  ///< as in "Z16 640x480, 30 per second"
};

/// Sets format, size and rate as the options say. Throws an Error that says what the device offers where it
/// has no such format, size or rate, and as V4l2Device::request does.
V4l2Mode set_mode(const V4l2Device& device, const V4l2Options& options);

}  // namespace knuckle
