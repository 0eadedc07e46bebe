// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/reliability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

struct BinSums {
  RunningMean confidence;
  RunningMean within;
};

using Sums = std::array<BinSums, kReliabilityBins>;

/// Distances of an estimate's landmarks from those of a true hand [mm]; NaN where one does not know it.
std::vector<double> distances(const TrueHand& truth, const HandRecord& estimate,
                              std::span<const int> place_in_truth) {
  std::vector<double> result(estimate.landmarks_mm.size(), kNaN);
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (place_in_truth[i] < 0) continue;
    const Point3& labelled = truth.landmarks_mm[static_cast<std::size_t>(place_in_truth[i])];
    result[i] = (estimate.landmarks_mm[i] - labelled).norm();
  }
  return result;
}

double mean_of(const std::vector<double>& distances) {
  RunningMean mean;
  for (const double distance : distances) {
    if (std::isfinite(distance)) mean.add(distance);
  }
  return mean.count > 0 ? mean.value() : std::numeric_limits<double>::infinity();
}

void add_hand(const HandRecord& estimate, const TrueHands& truth, const Convention& convention, Sums& sums) {
  if (estimate.confidence.empty() || truth.hands.empty()) return;
  const ConventionMapping mapping = map_convention(convention, estimate.convention);
  std::vector<double> nearest;
  std::optional<HandSide> side;
  for (const TrueHand& hand : truth.hands) {
    std::vector<double> here = distances(hand, estimate, mapping.source_index);
    if (!nearest.empty() && mean_of(here) >= mean_of(nearest)) continue;
    nearest = std::move(here);
    side = hand.side;
  }
  if (estimate.side && estimate.side != side) return;
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const double confidence = estimate.confidence[i];
    if (!std::isfinite(nearest[i]) || !std::isfinite(confidence)) continue;
    const int bin = std::clamp(static_cast<int>(confidence * kReliabilityBins), 0, kReliabilityBins - 1);
    sums[static_cast<std::size_t>(bin)].confidence.add(confidence);
    sums[static_cast<std::size_t>(bin)].within.add(nearest[i] <= kReliableMm ? 1.0 : 0.0);
  }
}

}  // namespace

Reliability reliability_of(const Convention& convention, std::span<const TrueHands> truth,
                           std::span<const FrameRecord> records) {
  if (truth.size() != records.size())
    fail("{} records, expected one for each of {} frames", records.size(), truth.size());
  Sums sums;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (const HandRecord& hand : records[i].hands) add_hand(hand, truth[i], convention, sums);
  }
  Reliability reliability;
  double error = 0.0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const std::int64_t joints = sums[i].confidence.count;
    if (joints == 0) continue;
    const double confidence = sums[i].confidence.value();
    const double within = sums[i].within.value();
    reliability.bins[i] = {joints, confidence, within};
    reliability.joints += joints;
    error += static_cast<double>(joints) * std::abs(confidence - within);
  }
  if (reliability.joints > 0) reliability.error = error / static_cast<double>(reliability.joints);
  return reliability;
}

}  // namespace knuckle
