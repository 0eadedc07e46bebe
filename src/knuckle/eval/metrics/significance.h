// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "knuckle/eval/metrics/metrics.h"

namespace knuckle {

/// How much nearer to the truth one method is than another, and how sure that is: a paired bootstrap over the
/// frames in which both have a pose. Frames that follow each other have similar errors, so blocks of them are
/// drawn (circular block bootstrap, Politis and Romano 1992), as long as Politis and White (2004) ask for
/// where errors fade like those of an autoregressive process of first order.
struct MethodDifference {
  std::size_t first = 0;  ///< places among the methods
  std::size_t second = 0;
  std::int64_t frames = 0;        ///< in which both have a pose
  std::int64_t block_frames = 1;  ///< length of the blocks that were drawn
  double mean_mm = kNaN;          ///< mean 3D error of the first less that of the second, over these frames
  double low_mm = kNaN;           ///< ends of its 95 % interval
  double high_mm = kNaN;
  /// How often chance alone would make such a difference, two-sided, [0, 1]; at least 0.001.
  double p_value = kNaN;
};

/// Compares two methods frame by frame; both were scored against the same truth in the same landmarks. The
/// same numbers on every run. All is NaN but `frames` where fewer than two frames have a pose of both.
MethodDifference difference(const MethodScore& first, const MethodScore& second);

/// All pairs of up to six methods, of more the best (the least mean error) with each other one.
std::vector<MethodDifference> differences(const std::vector<MethodScore>& methods);

}  // namespace knuckle
