// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "knuckle/core/statistics.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/eval/metrics/occlusion_score.h"
#include "knuckle/eval/metrics/true_hands.h"

namespace knuckle {

/// Gathers the landmarks of found hands by what lies before them.
class OcclusionCount {
 public:
  /// `places`: of the truth's landmarks in the estimate's list, -1 where it lacks one. Nothing is counted
  /// where it is not known what hides the landmarks.
  void add(const TrueHand& truth, const HandRecord& estimate, std::span<const int> places);

  OcclusionScores scores() const;

 private:
  struct Sums {
    RunningMean error_mm;
    RunningMean within;
    RunningMean confidence;
  };
  std::array<Sums, kOccluderCount> sums_;
};

}  // namespace knuckle
