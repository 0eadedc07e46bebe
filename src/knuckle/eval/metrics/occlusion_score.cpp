// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/occlusion_score.h"

#include <cmath>

#include "knuckle/eval/metrics/reliability.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, kOccluderCount> kNames = {"none",   "own_hand", "other_hand",
                                                                 "person", "object",   "border"};

/// The mean of two means, each weighed by its joints; one that is not known counts for nothing.
double joined(double mean, std::int64_t joints, double other, std::int64_t others) {
  if (joints == 0 || std::isnan(mean)) return other;
  if (others == 0 || std::isnan(other)) return mean;
  const auto all = static_cast<double>(joints + others);
  return (mean * static_cast<double>(joints) + other * static_cast<double>(others)) / all;
}

}  // namespace

std::string_view name_of(Occluder occluder) {
  return kNames[static_cast<std::size_t>(occluder)];
}

OcclusionScore hidden_of(const OcclusionScores& scores) {
  OcclusionScore hidden;
  for (std::size_t i = 1; i < scores.size(); ++i) {
    const OcclusionScore& score = scores[i];
    hidden = {hidden.joints + score.joints,
              joined(hidden.mean_3d_mm, hidden.joints, score.mean_3d_mm, score.joints),
              joined(hidden.within, hidden.joints, score.within, score.joints),
              joined(hidden.confidence, hidden.joints, score.confidence, score.joints)};
  }
  return hidden;
}

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
