// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <memory>
#include <optional>

#include "knuckle/hand/skeleton_fit.h"
#include "knuckle/pipeline/tracker_options.h"

namespace knuckle {

/// Smooths the pose of one hand from frame to frame: wrist and angles, by what `TrackerOptions::smoothing`
/// names, the turn on the rotation group. Size and lengths are not smoothed. One caller.
class PoseSmoother {
 public:
  /// Throws an Error where an option is out of range.
  explicit PoseSmoother(const TrackerOptions& options);
  ~PoseSmoother();
  PoseSmoother(PoseSmoother&&) noexcept;
  PoseSmoother& operator=(PoseSmoother&&) noexcept;

  /// The smoothed pose; `seconds` since the one before, above 0. The first pose comes back as it is.
  SkeletonPose smooth(const SkeletonPose& pose, double seconds);
  /// Forgets what came before.
  void reset();

 private:
  class Filter;
  class OneEuro;
  class RestMotion;

  std::unique_ptr<Filter> filter_;           // null: nothing is smoothed
  std::optional<Eigen::Matrix3d> rotation_;  // the smoothed one
  Eigen::Vector3d turned_so_far_ =
      Eigen::Vector3d::Zero();  // sum of its small turns: what the filter's value is
};

}  // namespace knuckle
