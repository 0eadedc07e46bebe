// SPDX-License-Identifier: Apache-2.0
// Helpers for tests and benchmarks only; not part of the library.
#pragma once

#include <algorithm>
#include <cmath>

#include "knuckle/segment/detector/detection.h"
#include "knuckle/segment/detector/detector_file.h"

namespace knuckle::testing {

inline DetectorOptions small_detector() {
  return {.width = 64,
          .height = 48,
          .focal_cells = 43.0,
          .stem_channels = 8,
          .quarter_channels = 16,
          .eighth_channels = 16,
          .sixteenth_channels = 16,
          .head_channels = 16};
}

/// A detector that sees one and the same hand in any frame of this camera: all its weights are 0, and what
/// its first cell says is in the bias of its head.
inline DetectorWeights constant_detector(const DetectorOptions& options, const Camera& camera,
                                         const DetectedHand& hand) {
  DetectorWeights weights(options);
  for (const NetworkArray& array : weights.arrays()) {
    if (array.name.ends_with(".running_var")) std::ranges::fill(weights.singles(array.name), 1.0f);
  }
  const ViewPlace place = DetectorView(options, camera).to_view(hand.centre);
  const auto in_maps = [](double cell) { return (cell - 0.5 * (kMapStride - 1)) / kMapStride; };
  const auto logit = [](double share) { return std::log(share / (1.0 - share)); };
  const auto bias = weights.halves("head.bias");
  const auto set = [&](int map, double value) {
    bias[static_cast<std::size_t>(map)] = half_of_float(static_cast<float>(value));
  };
  set(kHeatMap, logit(hand.score));
  set(kOffsetUMap, in_maps(place.u));
  set(kOffsetVMap, in_maps(place.v));
  set(kInverseDepthMap, std::log(place.inverse_depth));
  set(kExtentMap, std::log(hand.extent_mm / kExtentUnitMm));
  const double right = hand.side == HandSide::right ? hand.side_confidence : 1.0 - hand.side_confidence;
  set(kSideMap, logit(right));
  return weights;
}

}  // namespace knuckle::testing
