// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <optional>

#include <c10/core/Event.h>
#include <c10/core/Stream.h>
#include <c10/core/StreamGuard.h>
#include <torch/types.h>

namespace knuckle {

/// A point in what a thread has asked a GPU to do. A processor has done what it was asked: there it is
/// nothing.
class DeviceMark {
 public:
  explicit DeviceMark(const torch::Device& device);

  /// After all that the calling thread has asked for until now.
  void set();
  /// What the calling thread asks for from now on begins after the mark.
  void wait();

 private:
  torch::Device device_;
  std::optional<c10::Event> event_;
};

/// A way for work on a GPU to go beside the work that threads usually ask it for, which is done one after
/// the other. On a processor it is nothing.
class SideStream {
 public:
  explicit SideStream(const torch::Device& device);

  /// What the calling thread asks for goes this way while the guard lives.
  c10::OptionalStreamGuard used() const { return c10::OptionalStreamGuard(stream_); }

 private:
  c10::optional<c10::Stream> stream_;  // the guard's type of an optional
};

}  // namespace knuckle
