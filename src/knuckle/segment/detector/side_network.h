// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/core/pose.h"
#include "knuckle/segment/detector/hand_detector.h"

namespace knuckle {

/// Tells left hands from right ones by what is seen around them: the arm, and the body that it belongs to. It
/// is a detector (docs/detector.md) of whose answers only the sides count. It sees each frame twice, as it is
/// and in a mirror, where all sides are exchanged, and the mean of its log odds counts: what it says of both
/// pictures alike it does not know.
class SideNetwork {
 public:
  explicit SideNetwork(const DetectorWeights& weights) : network_(weights) {}

  /// How likely each hand is a right one, (0, 1), by its centre in camera coordinates [mm]: what the network
  /// says at that place, or at the nearest one that it sees; 0.5 of what lies nowhere before the camera. The
  /// depth image has the camera's size and a pixel at least. Safe to call from many threads.
  std::vector<double> right_hands(const Frame& frame, std::span<const Point3> centres) const;

 private:
  HandDetector network_;
};

}  // namespace knuckle
