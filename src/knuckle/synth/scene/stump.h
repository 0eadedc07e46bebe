// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

#include "knuckle/core/random.h"

namespace knuckle {

/// Where an arm ends that has no hand.
struct Stump {
  float from_mm = 0.0f;   ///< along the arm, from the wrist towards the elbow [mm]
  float depth_mm = 0.0f;  ///< how far its end bulges; 0: as if cut off
};

/// Anywhere between the wrist and the middle of the forearm.
Stump sampled_stump(Random& random);

/// Draws the skin that lies nearer to the hand than the stump, and the hand, together to its end: a closed
/// cap. `limb` and `along_mm` (`way_along_arm`) belong together; all in the camera frame [mm].
void end_in_stump(std::span<Eigen::Vector3f> limb, std::span<const float> along_mm, const Stump& stump,
                  const Eigen::Vector3f& wrist, const Eigen::Vector3f& elbow);

}  // namespace knuckle
