// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detection.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "knuckle/core/likelihood.h"

namespace knuckle {
namespace {

// What a network that was trained never says, and arithmetic must survive.
constexpr double kLeastInverseDepth = 0.02;  // of something 50 m away [1/m]
constexpr double kLeastExtentMm = 20.0;
constexpr double kMostExtentMm = 250.0;

/// Whether no neighbour has more heat; of equal cells the first one, row by row, is the peak.
bool is_peak(const DetectorMaps& maps, int column, int row) {
  const float heat = maps.cell(column, row)[kHeatMap];
  for (int y = std::max(0, row - 1); y <= std::min(maps.height - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(maps.width - 1, column + 1); ++x) {
      const float other = maps.cell(x, y)[kHeatMap];
      const bool is_before = y < row || (y == row && x < column);
      if (other > heat || (other == heat && is_before)) return false;
    }
  }
  return true;
}

DetectedHand hand_at(const DetectorMaps& maps, int column, int row, const DetectorView& view) {
  const float* const said = maps.cell(column, row);
  const auto in_picture = [](double cell) { return cell * kMapStride + 0.5 * (kMapStride - 1); };
  const ViewPlace place{in_picture(column + said[kOffsetUMap]), in_picture(row + said[kOffsetVMap]),
                        std::clamp(std::exp(static_cast<double>(said[kInverseDepthMap])), kLeastInverseDepth,
                                   kMostInverseDepth)};
  const double right = logistic(said[kSideMap]);
  return {.centre = view.to_camera(place),
          .extent_mm = std::clamp(kExtentUnitMm * std::exp(static_cast<double>(said[kExtentMap])),
                                  kLeastExtentMm, kMostExtentMm),
          .score = logistic(said[kHeatMap]),
          .side = right >= 0.5 ? HandSide::right : HandSide::left,
          .side_confidence = std::max(right, 1.0 - right)};
}

}  // namespace

void DetectionOptions::visit(OptionVisitor& visitor) {
  visitor.real("min_score", min_score, closed(0, 1));
  visitor.real("separation_mm", separation_mm, closed(0, 1000));
}

std::vector<DetectedHand> hands_in(const DetectorMaps& maps, const DetectorView& view,
                                   const DetectionOptions& options) {
  std::vector<DetectedHand> peaks;
  for (int row = 0; row < maps.height; ++row) {
    for (int column = 0; column < maps.width; ++column) {
      if (logistic(maps.cell(column, row)[kHeatMap]) < options.min_score) continue;
      if (is_peak(maps, column, row)) peaks.push_back(hand_at(maps, column, row, view));
    }
  }
  std::ranges::stable_sort(peaks, std::greater{}, &DetectedHand::score);
  std::vector<DetectedHand> hands;
  for (const DetectedHand& peak : peaks) {
    const auto is_same = [&](const DetectedHand& hand) {
      return (hand.centre - peak.centre).norm() < options.separation_mm;
    };
    if (std::ranges::none_of(hands, is_same)) hands.push_back(peak);
  }
  return hands;
}

}  // namespace knuckle
