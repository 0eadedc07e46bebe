// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/occlusion_count.h"

#include <cmath>

#include "knuckle/eval/metrics/reliability.h"

namespace knuckle {

void OcclusionCount::add(const TrueHand& truth, const HandRecord& estimate, std::span<const int> places) {
  for (std::size_t i = 0; i < truth.occluders.size(); ++i) {
    if (places[i] < 0) continue;
    const auto place = static_cast<std::size_t>(places[i]);
    const double error_mm = (estimate.landmarks_mm[place] - truth.landmarks_mm[i]).norm();
    if (!std::isfinite(error_mm)) continue;
    Sums& sums = sums_[static_cast<std::size_t>(truth.occluders[i])];
    sums.error_mm.add(error_mm);
    sums.within.add(error_mm <= kReliableMm ? 1.0 : 0.0);
    if (!estimate.confidence.empty() && std::isfinite(estimate.confidence[place]))
      sums.confidence.add(estimate.confidence[place]);
  }
}

OcclusionScores OcclusionCount::scores() const {
  OcclusionScores scores;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const Sums& sums = sums_[i];
    scores[i] = {sums.error_mm.count, sums.error_mm.value(), sums.within.value(), sums.confidence.value()};
  }
  return scores;
}

}  // namespace knuckle
