// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/fitted_flesh.h"

namespace knuckle {

std::vector<FleshCone> fitted_flesh(const HandRecord& hand) {
  if (hand.skeleton.empty()) return {};
  SupersetPoints points;
  points.fill(Point3::Constant(kNaN));
  for (std::size_t i = 0; i < hand.landmarks_mm.size(); ++i) {
    const auto landmark = static_cast<std::size_t>(hand.convention.landmarks[i]);
    if (landmark < points.size()) points[landmark] = hand.landmarks_mm[i];
  }
  return flesh_cones(points);
}

}  // namespace knuckle
