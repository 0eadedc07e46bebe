// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/frame.h"
#include "knuckle/core/pose.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

/// Improves an estimated pose with what the frame shows: the paper's postprocessing.
class Refiner {
 public:
  virtual ~Refiner() = default;

  /// `pose` was estimated from `hand` in `frame`. Safe to call from many threads.
  virtual HandPose refine(const Frame& frame, const HandRegion& hand, HandPose pose) const = 0;
};

}  // namespace knuckle
