// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/point_cloud.h"

#include <cassert>
#include <numeric>
#include <utility>

#include "knuckle/segment/depth_interval.h"

namespace knuckle {
namespace {

constexpr float kFarAway = 1e9f;  // [mm]: exp(-r / h) is 0 there for every bandwidth

/// A cloud of these pixels whose points are still to be set; those that fill it up are far away.
PointCloud make_cloud(std::vector<std::int32_t> pixels) {
  PointCloud cloud;
  cloud.pixels = std::move(pixels);
  for (Eigen::ArrayXf* coordinate : {&cloud.x, &cloud.y, &cloud.z}) {
    coordinate->resize(cloud.padded_size());
    coordinate->tail(cloud.padded_size() - cloud.size()).setConstant(kFarAway);
  }
  return cloud;
}

/// Keeps each step-th pixel.
void thin(std::vector<std::int32_t>& pixels, int step) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < pixels.size(); i += static_cast<std::size_t>(step)) pixels[count++] = pixels[i];
  pixels.resize(count);
}

/// Keeps the pixels whose points lie within a ball. There may be ten times as many outside of it, at its
/// depth: they are dropped before there is room for their points, since memory that was never used costs more
/// than arithmetic.
template <typename PointOf>
void keep_within(std::vector<std::int32_t>& pixels, PointOf point_of, const Eigen::Array3f& centre,
                 float squared_radius) {
  std::size_t count = 0;
  for (const std::int32_t pixel : pixels) {
    const Eigen::Array3f off = point_of(pixel) - centre;
    pixels[count] = pixel;
    count += off.x() * off.x() + off.y() * off.y() + off.z() * off.z() <= squared_radius ? 1 : 0;
  }
  pixels.resize(count);
}

}  // namespace

PointCloud points_around(const Image<float>& depth_mm, const RayTable& rays, const Point3& centre,
                         double radius_mm, int most) {
  assert(rays.rays_x().size() == depth_mm.size());
  std::vector<std::int32_t> pixels = pixels_between(depth_mm, centre.z() - radius_mm, centre.z() + radius_mm);
  const auto thinning = static_cast<int>((std::ssize(pixels) - 1) / most + 1);
  if (thinning > 1) thin(pixels, thinning);

  const bool is_orthographic = rays.camera().model == CameraModel::orthographic;
  const auto point_of = [&](std::int32_t pixel) {
    const float z = depth_mm.data()[pixel];
    const float scale = is_orthographic ? 1.0f : z;
    return Eigen::Array3f(rays.rays_x().data()[pixel] * scale, rays.rays_y().data()[pixel] * scale, z);
  };
  keep_within(pixels, point_of, centre.cast<float>(), static_cast<float>(radius_mm * radius_mm));
  PointCloud cloud = make_cloud(std::move(pixels));
  for (int i = 0; i < cloud.size(); ++i) {
    const Eigen::Array3f point = point_of(cloud.pixels[i]);
    cloud.x[i] = point.x();
    cloud.y[i] = point.y();
    cloud.z[i] = point.z();
  }
  cloud.thinning = thinning;
  return cloud;
}

PointCloud cloud_of(const std::vector<Point3>& points) {
  std::vector<std::int32_t> pixels(points.size());
  std::iota(pixels.begin(), pixels.end(), 0);
  PointCloud cloud = make_cloud(std::move(pixels));
  for (int i = 0; i < cloud.size(); ++i) {
    cloud.x[i] = static_cast<float>(points[i].x());
    cloud.y[i] = static_cast<float>(points[i].y());
    cloud.z[i] = static_cast<float>(points[i].z());
  }
  return cloud;
}

}  // namespace knuckle
