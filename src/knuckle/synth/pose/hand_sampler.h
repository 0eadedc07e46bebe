// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/core/random.h"
#include "knuckle/hand/hand_angles.h"

namespace knuckle {

/// Where hand poses come from: shares need not sum to 1, and 0 leaves a kind out.
struct HandPoseOptions {
  double gesture_share = 0.10;  ///< one named gesture, at least 0
  double pair_share = 0.30;     ///< between two random gestures (the paper's recipe), at least 0
  double mixed_share = 0.08;    ///< each digit between gestures of its own, at least 0
  double closing_share = 0.12;  ///< between a closed and an open hand, at least 0
  double grasp_share = 0.30;    ///< around a thing, with evenly bent fingers, at least 0
  double uniform_share = 0.10;  ///< anywhere within the limits of the joints, at least 0
  double touch_share = 0.0;  ///< the thumb touches a finger: rings, pinches, thumbs across a fist, at least 0
  double jitter_deg = 6.0;   ///< deviation of what is added to each angle of the first four and, before the
                             ///< thumb touches, of touch, [0, 45] [degree]
  double penetration_mm = 6.0;             ///< how deep digits may run into one another, at least 0 [mm]
  std::vector<std::string> gestures = {};  ///< names that are drawn from; empty: all
  std::vector<std::string> without_gestures = {};  ///< names that are left out of those

  void visit(OptionVisitor& visitor);
};

/// The names that the options leave to draw from.
std::vector<std::string_view> allowed_gestures(const HandPoseOptions& options);

/// Throws an Error that starts with `what` where a value is out of range, all shares are 0, or too few
/// gestures are left for a kind that has a share.
void check(const HandPoseOptions& options, std::string_view what);

/// A random hand, within the limits of the joints. Does not look for penetration.
HandAngles sampled_hand(const HandPoseOptions& options, Random& random);

}  // namespace knuckle
