// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace knuckle {

float Solid::distance_mm(const Eigen::Vector3f& point) const {
  const Eigen::Vector3f p = thing_from_solid.linear().transpose() * (point - thing_from_solid.translation());
  switch (kind) {
    case Kind::box:
      return (p.cwiseAbs() - size).maxCoeff();
    case Kind::cone: {
      const float up = (p.z() / size.z() + 1.0f) * 0.5f;  // 0 at the bottom, 1 at the top
      const float radius = size.x() + std::clamp(up, 0.0f, 1.0f) * (size.y() - size.x());
      const float slope = (size.y() - size.x()) / (2.0f * size.z());
      const float beside =
          (std::sqrt(p.x() * p.x() + p.y() * p.y()) - radius) / std::sqrt(1.0f + slope * slope);
      return std::max(beside, std::abs(p.z()) - size.z());
    }
    default:
      return p.norm() - size.x();
  }
}

float distance_mm(std::span<const Solid> solids, const Eigen::Vector3f& point) {
  float least = std::numeric_limits<float>::infinity();
  for (const Solid& solid : solids) least = std::min(least, solid.distance_mm(point));
  return least;
}

}  // namespace knuckle
