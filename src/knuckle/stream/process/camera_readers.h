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

// Each sends what there is to say, and returns when the program wants no more. Faults are Errors.
void list_freenect(const Program& program);
void read_freenect(const Program& program, int index, bool in_millimetres);
void list_openni2(const Program& program);
void read_openni2(const Program& program, const std::string& uri, int width, int height, int rate_hz);
void read_oni(const Program& program, const std::string& path);

}  // namespace knuckle
