// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "knuckle/eval/metrics/joint_errors.h"
#include "knuckle/eval/metrics/motion.h"

namespace knuckle {

/// Error statistics of one landmark, over the frames with a prediction and with truth for it; NaN where there
/// are none.
struct JointScore {
  Landmark landmark;
  std::int64_t frames = 0;  ///< that these are computed over
  double mean_3d_mm = kNaN;
  double median_3d_mm = kNaN;
  double mean_2d_px = kNaN;
  double median_2d_px = kNaN;
};

/// Fractions of frames or joints within a distance D of the truth, for D = 0, 1, ..., 80 mm. "Within"
/// includes D itself. Each rises with D and lies in [0, 1]; a missing prediction is within no distance. The
/// last pair is the same in the image, for R = 0, 1, ..., 40 px.
struct ErrorCurves {
  std::vector<double> threshold_mm;
  std::vector<double> all_joints_within;  ///< frames whose worst joint is within D (Taylor et al. 2012)
  std::vector<double> mean_within;        ///< frames whose mean joint error is within D
  std::vector<double>
      joints_within;  ///< joints within D: percentage of correct keypoints (PCK), as a fraction
  std::vector<double> threshold_px;
  std::vector<double> joints_within_px;  ///< joints within R
};

/// The distances in mm for which tables and JSON give the fraction of frames with all joints within.
inline constexpr std::array<int, 3> kTableThresholdsMm = {20, 30, 40};
/// The PCK curve's area is taken from 0 to this distance [mm].
inline constexpr double kAucLimitMm = 50.0;

/// How good one method is. Means and medians are over all joints of all frames with a prediction; fractions
/// are of all frames with truth, so that a missing prediction lowers them.
struct MethodScore {
  std::string name;
  std::int64_t frames = 0;                    ///< all frames
  std::int64_t scored_frames = 0;             ///< those in which the truth knows at least one compared joint
  std::int64_t missing = 0;                   ///< scored frames without a (complete) prediction
  std::vector<Landmark> only_in_truth;        ///< landmarks that could not be compared
  std::vector<Landmark> only_in_predictions;  ///< landmarks that could not be compared
  std::vector<JointScore> joints;             ///< one per compared landmark

  double mean_3d_mm = kNaN;
  double median_3d_mm = kNaN;
  double mean_2d_px = kNaN;
  double median_2d_px = kNaN;
  std::array<double, kTableThresholdsMm.size()> frames_all_joints_within{};  ///< [0, 1]
  double auc_pck_0_50 = 0.0;  ///< area under the exact PCK curve for 0-50 mm over its width, [0, 1]
  ErrorCurves curves;
  std::vector<double>
      frame_mean_3d_mm;  ///< one per frame; infinite where missing, NaN where the frame has no truth
  std::vector<double> frame_largest_3d_mm;  ///< of its worst joint, likewise
  MotionScore motion;                       ///< from frame to frame; set by `evaluate`
};

/// All measures of one method.
MethodScore score(const JointErrors& errors, const std::string& name);

}  // namespace knuckle
