// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "knuckle/data/frame_stream.h"

namespace knuckle {

/// Why a request to a video device failed, in words that say what to do. `name` is what the device is called
/// in messages, `what` was tried ("cannot be opened"), `error` is errno.
std::string v4l2_fault(std::string_view name, std::string_view what, int error);

/// Whether errno says that the device is not there any more.
bool is_gone(int error);

/// A device of Video4Linux that captures images and is open, until the end of its life.
class V4l2Device {
 public:
  /// `path` as in "/dev/video2". Throws an Error that says what to do where the device is not there, busy or
  /// forbidden, and where it is none that captures images.
  explicit V4l2Device(std::string path);
  ~V4l2Device();
  V4l2Device(const V4l2Device&) = delete;
  V4l2Device& operator=(const V4l2Device&) = delete;

  /// How messages call it: "v4l2:/dev/video2".
  const std::string& name() const { return name_; }
  /// What the camera calls itself; may hold any bytes.
  const std::string& card() const { return card_; }
  int descriptor() const { return descriptor_; }

  /// Makes a request (VIDIOC_...). Returns 0, or errno.
  template <class Argument>
  int try_request(unsigned long code, Argument& argument) const {
    return control(code, &argument);
  }
  /// The same. Throws an Error that says `what` could not be done; DeviceLost where it is gone.
  template <class Argument>
  void request(unsigned long code, Argument& argument, std::string_view what) const {
    if (const int error = control(code, &argument)) fail_with(error, what);
  }
  /// Throws as `request` does.
  [[noreturn]] void fail_with(int error, std::string_view what) const;
  /// Whether a frame came within that time. Throws DeviceLost where the device is gone.
  bool wait(std::chrono::milliseconds longest) const;

 private:
  int control(unsigned long code, void* argument) const;
  void require_capture();

  std::string path_;
  std::string name_;
  std::string card_;
  int descriptor_ = -1;
};

}  // namespace knuckle
