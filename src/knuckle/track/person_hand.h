// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "knuckle/core/statistics.h"
#include "knuckle/hand/skeleton_fit.h"

namespace knuckle {

/// Size and proportions of a person's hand as frames showed them: means of logarithms. A value.
class PersonHand {
 public:
  /// Learns from a skeleton that was fitted to a frame by itself.
  void learn(const SkeletonPose& pose);
  /// Makes what was learned known to a fit, which then keeps to it; nothing where nothing was learned.
  void tell(SkeletonFitOptions& options) const;

 private:
  RunningMean size_;
  std::array<RunningMean, 15> lengths_;
};

}  // namespace knuckle
