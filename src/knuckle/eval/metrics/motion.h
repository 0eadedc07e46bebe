// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/eval/metrics/joint_errors.h"

namespace knuckle {

/// How a method's estimates move from frame to frame, beside how the truth does. All are means over landmarks
/// that both have, in camera coordinates; NaN where no frames can tell.
struct MotionScore {
  /// Frames that, with the one before and the one after, are of one sequence and have truth and prediction.
  std::int64_t frames = 0;
  double acceleration_mm = kNaN;        ///< length of the second differences of the estimates [mm / frame^2]
  double true_acceleration_mm = kNaN;   ///< of the truth, in the same frames and joints
  double acceleration_error_mm = kNaN;  ///< of the difference of the two
  double lag_frames = kNaN;  ///< how late the estimates are: the shift at which they fit the truth best
  /// On a still hand: deviation of a landmark from its mean [mm], over stretches of kStillFrames frames or
  /// more in which no true joint moves.
  double jitter_mm = kNaN;
  double worst_jitter_mm = kNaN;  ///< of the landmark in which it is largest
  double bone_deviation = kNaN;   ///< standard deviation of a bone's length over its mean, within a sequence
};

inline constexpr int kStillFrames = 10;   ///< a hand that stands still for fewer says nothing about jitter
inline constexpr double kStillMm = 0.05;  ///< from frame to frame; what moves less stands still
inline constexpr double kMovingMm = 0.2;  ///< a truth that moves less on average says nothing about lag
inline constexpr double kUnrelatedMm =
    80.0;                                 ///< a truth that moves more is no motion: its frames are of a set
inline constexpr int kMostLagFrames = 5;  ///< longer lags are not looked for

/// Scores the motion of predictions that `joint_errors` can compare with the truth; `Truth::sequences` says
/// which frames follow each other; where its joints move more than kUnrelatedMm on average they do not, and
/// nothing is known. The lag is that of the least mean squared distance among whole shifts, refined by the
/// parabola through it and its neighbours, which is exact for constant speed.
MotionScore motion_score(const Truth& truth, const Predictions& predictions);

}  // namespace knuckle
