// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace knuckle {

/// Turns the times of a device into those of a stream: from 0 on, and never back. A time that would go back,
/// or leaps ahead of when the frame came, is replaced by when it came.
class StreamClock {
 public:
  /// `stamp_s`: by the device's clock, nothing where it has none; `arrival_s`: by the computer's. Both in
  /// seconds from any zero. Returns seconds since the first frame.
  double time_s(std::optional<double> stamp_s, double arrival_s);
  /// The device's clock may have begun anew.
  void restart_device();

 private:
  std::optional<double> first_arrival_s_;
  std::optional<double> offset_s_;  ///< from the device's clock to the stream's
  double last_s_ = 0.0;
};

}  // namespace knuckle
