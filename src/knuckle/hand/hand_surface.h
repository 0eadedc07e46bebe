// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "knuckle/core/pose.h"

namespace knuckle {

/// What a depth image shows near a hand, for a skeleton to be fitted to.
struct HandSurface {
  std::vector<Point3> points;  ///< on the hand, and maybe on what is beside it, in camera coordinates [mm]
  /// The depth that was measured where a point is seen [mm]; 0: nothing was, or it lies outside of the image.
  /// Not set: nobody knows where the hand is not.
  std::function<double(const Point3&)> depth_mm = {};
};

}  // namespace knuckle
