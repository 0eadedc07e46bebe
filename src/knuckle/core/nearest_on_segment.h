// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace knuckle {

/// Where the straight line between two ends is nearest to a point, as a share of the way from the first end
/// to the second, [0, 1]; 0 where both ends are one point. For vectors of doubles of any length, in any unit.
template <class Vector>
double nearest_share(const Vector& point, const Vector& from, const Vector& to) {
  const Vector way = to - from;
  const double length_squared = way.squaredNorm();
  return length_squared > 0.0 ? std::clamp((point - from).dot(way) / length_squared, 0.0, 1.0) : 0.0;
}

}  // namespace knuckle
