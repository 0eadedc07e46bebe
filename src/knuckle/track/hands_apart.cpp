// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/hands_apart.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "knuckle/camera/projection.h"
#include "knuckle/core/box.h"
#include "knuckle/core/nearest_on_segment.h"

namespace knuckle {
namespace {

double distance_to_segment(const Point3& point, const Point3& from, const Point3& to) {
  return (point - from - nearest_share(point, from, to) * (to - from)).norm();
}

/// The pixels that see what is within `reach_mm` of the skin.
Box box_around(const HandSkin& skin, double reach_mm, const Projection& projection) {
  const int width = projection.camera().width;
  const int height = projection.camera().height;
  double left = width;
  double top = height;
  double right = 0.0;
  double bottom = 0.0;
  for (const HandCapsule& capsule : skin) {
    for (const Point3& end : {capsule.from, capsule.to}) {
      const double nearest = end.z() - capsule.radius - reach_mm;
      if (!(nearest > 0.0)) return {0, 0, width, height};  // beside or behind the camera: it may be anywhere
      const ImagePoint at = projection.to_image(end);
      const double margin = (capsule.radius + reach_mm) * projection.pixels_per_mm(nearest);
      left = std::min(left, at.u - margin);
      right = std::max(right, at.u + margin + 1.0);
      top = std::min(top, at.v - margin);
      bottom = std::max(bottom, at.v + margin + 1.0);
    }
  }
  const auto inside = [](double value, int end) {
    return static_cast<int>(std::clamp(value, 0.0, 1.0 * end));
  };
  const int x = inside(left, width);
  const int y = inside(top, height);
  return {x, y, std::max(0, inside(right + 1.0, width) - x), std::max(0, inside(bottom + 1.0, height) - y)};
}

void remove_hand(Frame& frame, const Projection& projection, const HandSkin& other, const HandSkin& own,
                 double reach_mm) {
  const Box box = box_around(other, reach_mm, projection);
  for (int row = box.y; row < box.y + box.height; ++row) {
    for (int column = box.x; column < box.x + box.width; ++column) {
      float& depth = frame.depth_mm(column, row);
      if (!is_measured(depth)) continue;
      const Point3 point =
          projection.to_camera({static_cast<double>(column), static_cast<double>(row), depth});
      const double distance = distance_to_skin_mm(point, other);
      if (distance < reach_mm && distance < distance_to_skin_mm(point, own)) depth = 0.0f;
    }
  }
}

}  // namespace

double distance_to_skin_mm(const Point3& point, const HandSkin& skin) {
  double least = std::numeric_limits<double>::infinity();
  for (const HandCapsule& capsule : skin) {
    least = std::min(least, distance_to_segment(point, capsule.from, capsule.to) - capsule.radius);
  }
  return least;
}

Frame without_hands(const Frame& frame, std::span<const HandSkin> others, const HandSkin& own,
                    double reach_mm) {
  Frame apart = frame;
  const Projection projection(frame.camera);
  for (const HandSkin& other : others) remove_hand(apart, projection, other, own, reach_mm);
  return apart;
}

}  // namespace knuckle
