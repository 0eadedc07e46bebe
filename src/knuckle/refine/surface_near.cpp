// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/surface_near.h"

#include <algorithm>
#include <cmath>

#include "knuckle/camera/projection.h"
#include "knuckle/core/box.h"

namespace knuckle {
namespace {

constexpr double kNearMm =
    40.0;  ///< the longest bones, those of the palm, have landmarks no farther from their middle

/// The pixels that points `kNearMm` around the targets are seen in.
Box box_around(const LandmarkTargets& targets, const Projection& projection) {
  double left = projection.camera().width;
  double top = projection.camera().height;
  double right = -1.0;
  double bottom = -1.0;
  for (const LandmarkTarget& target : targets) {
    if (!target.point.allFinite()) continue;
    const ImagePoint at = projection.to_image(target.point);
    if (at.is_missing()) continue;
    const double margin = kNearMm * projection.pixels_per_mm(at.depth_mm);
    left = std::min(left, at.u - margin);
    right = std::max(right, at.u + margin);
    top = std::min(top, at.v - margin);
    bottom = std::max(bottom, at.v + margin);
  }
  const int x = static_cast<int>(std::clamp(left, 0.0, static_cast<double>(projection.camera().width)));
  const int y = static_cast<int>(std::clamp(top, 0.0, static_cast<double>(projection.camera().height)));
  const int end_x =
      static_cast<int>(std::clamp(right + 1.0, 0.0, static_cast<double>(projection.camera().width)));
  const int end_y =
      static_cast<int>(std::clamp(bottom + 1.0, 0.0, static_cast<double>(projection.camera().height)));
  return {x, y, std::max(0, end_x - x), std::max(0, end_y - y)};
}

bool is_near(const Point3& point, const LandmarkTargets& targets) {
  return std::ranges::any_of(targets, [&](const LandmarkTarget& target) {
    return (target.point - point).squaredNorm() < kNearMm * kNearMm;  // false where it is NaN
  });
}

/// Calls `visit` with every `step`-th pixel's point, both ways, that is near.
template <class Visit>
void for_each_near(const Frame& frame, const Projection& projection, const Box& box,
                   const LandmarkTargets& targets, int step, const Visit& visit) {
  for (int row = box.y + step / 2; row < box.y + box.height; row += step) {
    for (int column = box.x + step / 2; column < box.x + box.width; column += step) {
      const float depth = frame.depth_mm(column, row);
      if (!is_measured(depth)) continue;
      const Point3 point =
          projection.to_camera({static_cast<double>(column), static_cast<double>(row), depth});
      if (is_near(point, targets)) visit(point);
    }
  }
}

}  // namespace

HandSurface surface_near(const Frame& frame, const LandmarkTargets& targets, int most) {
  const Projection projection(frame.camera);
  const Box box = box_around(targets, projection);
  HandSurface surface;
  // A first, coarse look tells what part of the box is near, and so how fine the second one has to be.
  const double area = static_cast<double>(box.width) * box.height;
  const int coarse = std::max(1, static_cast<int>(std::sqrt(area / (4.0 * most))));
  int count = 0;
  for_each_near(frame, projection, box, targets, coarse, [&](const Point3&) { ++count; });
  const int step =
      std::max(1, static_cast<int>(std::lround(coarse * std::sqrt(static_cast<double>(count) / most))));
  for_each_near(frame, projection, box, targets, step,
                [&](const Point3& point) { surface.points.push_back(point); });
  surface.depth_mm = [&frame, projection](const Point3& point) -> double {
    const ImagePoint at = projection.to_image(point);
    if (at.is_missing()) return 0.0;
    const double column = std::round(at.u);
    const double row = std::round(at.v);
    if (!(column >= 0.0 && row >= 0.0 && column < frame.depth_mm.width() && row < frame.depth_mm.height()))
      return 0.0;
    const float depth = frame.depth_mm(static_cast<int>(column), static_cast<int>(row));
    return is_measured(depth) ? depth : 0.0;
  };
  return surface;
}

}  // namespace knuckle
