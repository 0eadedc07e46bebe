// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/core/frame.h"

namespace knuckle {

/// A true hand: where its landmarks are, and how much of it can be seen.
struct TrueHand {
  HandSide side = HandSide::right;
  std::vector<Point3> landmarks_mm;      ///< in the order of the convention, camera coordinates [mm]
  double visible_share = 1.0;            ///< of its pixels, [0, 1]; 0 where its middle lies outside the image
  std::vector<Occluder> occluders = {};  ///< what lies before each landmark; none: not known
};

/// The true hands of a frame.
struct TrueHands {
  int sequence = 0;  ///< frames of one sequence belong together
  std::vector<TrueHand> hands;
};

}  // namespace knuckle
