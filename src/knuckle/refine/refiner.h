// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "knuckle/core/frame.h"
#include "knuckle/core/pose.h"
#include "knuckle/hand/hand_angles.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

/// A pose that was improved, and what else was found on the way.
struct RefinedHand {
  HandPose pose;
  std::optional<HandAngles> angles = {};  ///< of the skeleton that was fitted; nothing where none was
  std::string skeleton = {};              ///< its name; empty where none was
  double plausibility = 1.0;  ///< that this is a hand at all, (0, 1]: its score has the square root
};

/// Improves an estimated pose with what the frame shows: the paper's postprocessing.
class Refiner {
 public:
  virtual ~Refiner() = default;

  /// `pose` was estimated from `hand` in `frame`. Safe to call from many threads.
  virtual RefinedHand refine(const Frame& frame, const HandRegion& hand, HandPose pose) const = 0;
};

}  // namespace knuckle
