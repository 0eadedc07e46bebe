// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <optional>
#include <vector>

#include "knuckle/hand/skeleton_fit.h"
#include "knuckle/track/one_euro_filter.h"

namespace knuckle {

/// How the pose of a skeleton is smoothed: cutoffs of its wrist's place, of its turn, and of its angles.
struct PoseSmoothing {
  OneEuroOptions place{.rest_cutoff_hz = 1.0, .cutoff_per_speed = 0.06};  ///< speeds in mm/s
  OneEuroOptions turn{.rest_cutoff_hz = 1.0, .cutoff_per_speed = 6.0};    ///< speeds in rad/s
  OneEuroOptions angles{.rest_cutoff_hz = 1.0,
                        .cutoff_per_speed = 3.0};  ///< speeds in rad/s, each angle by itself
};

/// Smooths the pose of one hand from frame to frame: each part by the One Euro filter, the turn on the
/// rotation group. The size is not smoothed. One caller.
class PoseSmoother {
 public:
  /// Throws an Error where an option is out of range.
  explicit PoseSmoother(const PoseSmoothing& options);

  /// The smoothed pose; `seconds` since the one before, above 0. The first pose comes back as it is.
  SkeletonPose smooth(const SkeletonPose& pose, double seconds);
  /// Forgets what came before.
  void reset();

 private:
  OneEuroFilter place_;
  OneEuroFilter turn_;
  std::vector<OneEuroFilter> angles_;
  std::optional<Eigen::Matrix3d> rotation_;  // the smoothed one
  Eigen::Vector3d turned_so_far_ =
      Eigen::Vector3d::Zero();  // sum of its small turns: what the filter's value is
};

}  // namespace knuckle
