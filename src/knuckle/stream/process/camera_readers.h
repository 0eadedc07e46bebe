// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "knuckle/stream/camera_messages.h"

namespace knuckle {

/// Where a process that reads a camera sends its messages, and what it hears of the program that started it.
class Program {
 public:
  /// Messages go to this descriptor.
  explicit Program(int descriptor) : descriptor_(descriptor) {}

  void send(const PipedDescription& description) const;
  void send(const PipedFrame& frame, std::span<const std::uint8_t> pixels) const;
  void send_listing(const std::string& device, const std::string& name) const;
  void send_fault(const std::string& text) const;
  void send_end() const;
  /// Whether it wants no more.
  bool is_gone() const;

 private:
  int descriptor_;
};

/// Sends a listing of each Kinect. Throws an Error where libfreenect cannot be asked.
void list_freenect(const Program& program);
/// Sends what a Kinect gives until the program wants no more: raw, or in millimetres by its own calibration.
/// Throws an Error where that cannot be, or the Kinect is gone.
void read_freenect(const Program& program, int index, bool in_millimetres);
/// Sends a listing of each device that OpenNI2 sees. Throws an Error where it cannot be asked.
void list_openni2(const Program& program);
/// Sends what a device gives until the program wants no more. An empty `uri` is any device; 0 for a number is
/// what the device is set to. Throws an Error where that cannot be, or the device is gone.
void read_openni2(const Program& program, const std::string& uri, int width, int height, int rate_hz);
/// Sends all frames of an .oni file. Throws an Error where it is none, or no more frames come than it should
/// hold.
void read_oni(const Program& program, const std::string& path);

}  // namespace knuckle
