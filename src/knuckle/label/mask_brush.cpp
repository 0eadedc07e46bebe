// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/mask_brush.h"

#include <algorithm>
#include <cmath>

#include "knuckle/camera/projection.h"
#include "knuckle/core/nearest_on_segment.h"
#include "knuckle/hand/hand_flesh.h"

namespace knuckle {
namespace {

void paint_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double radius, std::uint8_t value,
                   Image<std::uint8_t>& pixels) {
  const auto first = [&](double a, double b) {
    return static_cast<int>(std::ceil(std::max(0.0, std::min(a, b) - radius)));
  };
  const auto last = [&](double a, double b, int size) {
    return static_cast<int>(std::floor(std::min(size - 1.0, std::max(a, b) + radius)));
  };
  for (int row = first(from.y(), to.y()); row <= last(from.y(), to.y(), pixels.height()); ++row) {
    for (int column = first(from.x(), to.x()); column <= last(from.x(), to.x(), pixels.width()); ++column) {
      const Eigen::Vector2d pixel(column, row);
      const Eigen::Vector2d nearest = from + nearest_share(pixel, from, to) * (to - from);
      if ((pixel - nearest).squaredNorm() <= radius * radius) pixels(column, row) = value;
    }
  }
}

bool is_near_flesh(const Point3& point, const std::array<Point3, kSupersetSize>& points, double palm_mm,
                   double margin_mm) {
  return std::ranges::any_of(hand_flesh(), [&](const HandFlesh& flesh) {
    const Point3& from = points[static_cast<std::size_t>(flesh.from)];
    const Point3& to = points[static_cast<std::size_t>(flesh.to)];
    const double share = nearest_share(point, from, to);
    const double radius = palm_mm * ((1.0 - share) * flesh.radius_from + share * flesh.radius_to) + margin_mm;
    return (point - from - share * (to - from)).squaredNorm() <= radius * radius;
  });
}

}  // namespace

void paint(const BrushStroke& stroke, Image<std::uint8_t>& pixels) {
  const auto at = [&](std::size_t i) { return Eigen::Vector2d(stroke.points[i][0], stroke.points[i][1]); };
  const std::uint8_t value = stroke.erases ? 0 : 1;
  for (std::size_t i = 0; i < stroke.points.size(); ++i)
    paint_between(at(i == 0 ? 0 : i - 1), at(i), stroke.radius_px, value, pixels);
}

Image<std::uint8_t> pixels_near_flesh(const Frame& frame, const std::array<Point3, kSupersetSize>& points,
                                      double margin_mm) {
  const double palm_mm = (points[static_cast<std::size_t>(Landmark::middle_mcp)] -
                          points[static_cast<std::size_t>(Landmark::wrist)])
                             .norm();
  const double reach_mm = 0.5 * palm_mm + margin_mm;  // no flesh is thicker
  Point3 low = points[0];
  Point3 high = points[0];
  for (const Point3& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  low.array() -= reach_mm;
  high.array() += reach_mm;
  const Projection projection(frame.camera);
  Image<std::uint8_t> pixels(frame.depth_mm.width(), frame.depth_mm.height());
  for (int row = 0; row < pixels.height(); ++row) {
    for (int column = 0; column < pixels.width(); ++column) {
      const float depth = frame.depth_mm(column, row);
      if (!is_measured(depth) || depth < low.z() || depth > high.z()) continue;
      const Point3 point =
          projection.to_camera({static_cast<double>(column), static_cast<double>(row), depth});
      const bool is_beside = (point.array() < low.array()).any() || (point.array() > high.array()).any();
      if (!is_beside && is_near_flesh(point, points, palm_mm, margin_mm)) pixels(column, row) = 1;
    }
  }
  return pixels;
}

}  // namespace knuckle
