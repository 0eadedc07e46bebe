// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/occlusion_score.h"

#include <cmath>

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

}  // namespace knuckle
