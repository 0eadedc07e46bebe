// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/side_network.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "knuckle/core/likelihood.h"

namespace knuckle {
namespace {

constexpr double kNobodyKnows = 0.5;

/// The cell of the maps that a place of the small picture lies in.
int map_cell(double place, int cells) {
  const double cell = (place - 0.5 * (kMapStride - 1)) / kMapStride;
  return static_cast<int>(std::lround(std::clamp(cell, 0.0, cells - 1.0)));
}

DetectorInput in_mirror(const DetectorInput& input) {
  return {mirrored(input.inverse_depth), mirrored(input.measured_share)};
}

}  // namespace

std::vector<double> SideNetwork::right_hands(const Frame& frame, std::span<const Point3> centres) const {
  std::vector<double> right;
  if (centres.empty()) return right;
  const std::shared_ptr<const DetectorView> view = network_.view_of(frame.camera);
  const DetectorInput input = view->shrink(frame.depth_mm);
  const DetectorMaps maps = network_.maps_of(input);
  const DetectorMaps mirror = network_.maps_of(in_mirror(input));
  for (const Point3& centre : centres) {
    if (!centre.allFinite() || centre.z() <= 0.0) {
      right.push_back(kNobodyKnows);
      continue;
    }
    const ViewPlace place = view->to_view(centre);
    const int column = map_cell(place.u, maps.width);
    const int row = map_cell(place.v, maps.height);
    const double odds = maps.cell(column, row)[kSideMap];
    const double odds_in_mirror = mirror.cell(maps.width - 1 - column, row)[kSideMap];
    right.push_back(logistic(0.5 * (odds - odds_in_mirror)));
  }
  return right;
}

}  // namespace knuckle
