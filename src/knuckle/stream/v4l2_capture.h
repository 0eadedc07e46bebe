// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/stream/v4l2_device.h"
#include "knuckle/stream/v4l2_negotiation.h"

namespace knuckle {

/// Memory that a device writes into.
class MappedBuffer {
 public:
  /// Throws an Error where the memory cannot be had.
  MappedBuffer(const V4l2Device& device, std::size_t bytes, std::uint32_t offset);
  ~MappedBuffer();
  MappedBuffer(MappedBuffer&& other) noexcept;
  MappedBuffer(const MappedBuffer&) = delete;
  MappedBuffer& operator=(const MappedBuffer&) = delete;

  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  std::span<std::uint8_t> bytes_;
};

/// A frame as the device gave it.
struct V4l2Frame {
  V4l2Images images;
  std::uint32_t number = 0;      ///< the device's own count, with those that were dropped
  std::optional<double> time_s;  ///< by the monotonic clock; nothing where the device has another clock
};

/// A device that sends, from its opening on.
class V4l2Capture {
 public:
  /// Throws an Error as V4l2Device and `set_mode` do, and where another program has the camera already.
  V4l2Capture(const std::string& path, const V4l2Options& options);
  ~V4l2Capture();
  V4l2Capture(const V4l2Capture&) = delete;
  V4l2Capture& operator=(const V4l2Capture&) = delete;

  const V4l2Device& device() const { return device_; }
  const V4l2Mode& mode() const { return mode_; }
  /// The next frame if one comes within that time and is whole. Throws DeviceLost where the camera is gone.
  std::optional<V4l2Frame> next(std::chrono::milliseconds longest);

 private:
  void map_buffers();
  void queue(std::uint32_t index) const;

  V4l2Device device_;
  V4l2Mode mode_;
  double depth_unit_mm_;
  std::vector<MappedBuffer> buffers_;
};

}  // namespace knuckle
