// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/side_network.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/likelihood.h"

namespace knuckle {
namespace {

/// The cell of the maps that a place of the small picture lies in.
int map_cell(double place, int cells) {
  const double cell = (place - 0.5 * (kMapStride - 1)) / kMapStride;
  return static_cast<int>(std::lround(std::clamp(cell, 0.0, cells - 1.0)));
}

}  // namespace

std::vector<double> SideNetwork::right_hands(const Frame& frame, std::span<const Point3> centres) const {
  std::vector<double> right;
  if (centres.empty()) return right;
  const SeenFrame seen = network_.see(frame);
  for (const Point3& centre : centres) {
    const ViewPlace place = seen.view->to_view(centre);
    const float* const said =
        seen.maps.cell(map_cell(place.u, seen.maps.width), map_cell(place.v, seen.maps.height));
    right.push_back(logistic(said[kSideMap]));
  }
  return right;
}

}  // namespace knuckle
