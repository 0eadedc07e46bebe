// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/surface_picture.h"

#include <optional>

#include "knuckle/camera/projection.h"
#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

/// What a pixel looks along. The depth of a place on it is the way there in lengths of the direction.
struct Ray {
  Point3 origin = Point3::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
};

/// The ray through a pixel of a view's picture.
Ray ray_through(const Projection& projection, const View& view, int column, int row) {
  const Point3 at = projection.to_camera(
      {(column + 0.5) / view.scale + view.crop.x - 0.5, (row + 0.5) / view.scale + view.crop.y - 0.5, 1.0});
  if (projection.camera().model == CameraModel::orthographic)
    return {{at.x(), at.y(), 0.0}, Eigen::Vector3d::UnitZ()};
  return {Point3::Zero(), at};
}

std::optional<SkinHit> nearest_hit(std::span<const FleshCone> flesh, const Ray& ray) {
  std::optional<SkinHit> nearest;
  for (const FleshCone& cone : flesh) {
    const auto hit = first_hit(cone, ray.origin, ray.direction);
    if (hit && (!nearest || hit->distance < nearest->distance)) nearest = hit;
  }
  return nearest;
}

/// What was measured at a pixel [mm]; NaN where nothing was, or it lies outside of the image.
double measured_at(const Image<float>& depth_mm, int column, int row) {
  if (column < 0 || row < 0 || column >= depth_mm.width() || row >= depth_mm.height()) return kNaN;
  const float depth = depth_mm(column, row);
  return is_measured(depth) ? depth : kNaN;
}

}  // namespace

SeenSurface seen_surface(std::span<const FleshCone> flesh, const Camera& camera, const View& view) {
  const Projection projection(camera);
  SeenSurface seen{Image<float>(view.width(), view.height()), Image<float>(view.width(), view.height())};
  for (int row = 0; row < view.height(); ++row) {
    for (int column = 0; column < view.width(); ++column) {
      const Ray ray = ray_through(projection, view, column, row);
      const auto hit = nearest_hit(flesh, ray);
      if (!hit) continue;
      seen.depth_mm(column, row) = static_cast<float>(hit->distance);
      seen.facing(column, row) =
          static_cast<float>(std::clamp(-hit->normal.dot(ray.direction.normalized()), 0.0, 1.0));
    }
  }
  return seen;
}

void draw_surface(Image<Rgb>& picture, const SeenSurface& surface) {
  constexpr double kOpaque = 0.7;
  constexpr double kDarkest = 0.15;
  constexpr Rgb kBlack{0, 0, 0};
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (!(surface.depth_mm.data()[i] > 0.0f)) continue;
    const double light = kDarkest + (1.0 - kDarkest) * surface.facing.data()[i];
    Rgb& pixel = picture.data()[i];
    pixel = mixed(pixel, mixed(kBlack, kEstimateColour, light), kOpaque);
  }
}

Rgb difference_colour(double difference_mm) {
  const double share = std::clamp(difference_mm / kDifferenceMm, -1.0, 1.0);
  return share < 0.0 ? mixed(kAlike, kMeasuredBefore, -share) : mixed(kAlike, kMeasuredBehind, share);
}

SurfaceDifference surface_difference(std::span<const FleshCone> flesh, const Image<float>& depth_mm,
                                     const Camera& camera, const View& view, const DepthRange& range) {
  constexpr double kDarkened = 0.65;
  constexpr Rgb kBlack{0, 0, 0};
  const View pixels{view.crop, 1.0};
  const SeenSurface surface = seen_surface(flesh, camera, pixels);
  Image<Rgb> picture = picture_of(depth_mm, pixels, range);
  std::vector<double> differences;
  for (int row = 0; row < picture.height(); ++row) {
    for (int column = 0; column < picture.width(); ++column) {
      Rgb& pixel = picture(column, row);
      const double skin = surface.depth_mm(column, row);
      const double difference = measured_at(depth_mm, view.crop.x + column, view.crop.y + row) - skin;
      if (!(skin > 0.0)) {
        pixel = mixed(pixel, kBlack, kDarkened);
      } else if (std::isnan(difference)) {
        pixel = kNotMeasured;
      } else {
        pixel = difference_colour(difference);
        differences.push_back(std::abs(difference));
      }
    }
  }
  return {resized(picture, view.width(), view.height()), median(differences)};
}

}  // namespace knuckle
