// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/point_cloud.h"

#include <cassert>

#include "knuckle/segment/depth_interval.h"

namespace knuckle {
namespace {

constexpr float kFarAway = 1e9f;  // [mm]: exp(-r / h) is 0 there for every bandwidth

/// Room for `count` points.
PointCloud make_cloud(std::size_t count) {
  PointCloud cloud;
  cloud.pixels.resize(count);
  for (Eigen::ArrayXf* coordinate : {&cloud.x, &cloud.y, &cloud.z}) coordinate->resize(cloud.padded_size());
  return cloud;
}

/// Keeps the first `count` points and puts far ones after them.
void cut_to(PointCloud& cloud, int count) {
  cloud.pixels.resize(static_cast<std::size_t>(count));
  const int padding = cloud.padded_size() - count;
  for (Eigen::ArrayXf* coordinate : {&cloud.x, &cloud.y, &cloud.z}) {
    coordinate->segment(count, padding).setConstant(kFarAway);
  }
}

/// Keeps each step-th pixel.
void thin(std::vector<std::int32_t>& pixels, int step) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < pixels.size(); i += static_cast<std::size_t>(step)) pixels[count++] = pixels[i];
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
  const Eigen::Array3f middle = centre.cast<float>();
  const auto squared_radius = static_cast<float>(radius_mm * radius_mm);
  PointCloud cloud = make_cloud(pixels.size());
  int count = 0;
  for (const std::int32_t pixel : pixels) {
    const float z = depth_mm.data()[pixel];
    const float scale = is_orthographic ? 1.0f : z;
    const float x = rays.rays_x().data()[pixel] * scale;
    const float y = rays.rays_y().data()[pixel] * scale;
    const float dx = x - middle.x();
    const float dy = y - middle.y();
    const float dz = z - middle.z();
    cloud.x[count] = x;
    cloud.y[count] = y;
    cloud.z[count] = z;
    cloud.pixels[count] = pixel;
    count += dx * dx + dy * dy + dz * dz <= squared_radius ? 1 : 0;
  }
  cut_to(cloud, count);
  cloud.thinning = thinning;
  return cloud;
}

PointCloud cloud_of(const std::vector<Point3>& points) {
  PointCloud cloud = make_cloud(points.size());
  for (int i = 0; i < cloud.size(); ++i) {
    cloud.x[i] = static_cast<float>(points[i].x());
    cloud.y[i] = static_cast<float>(points[i].y());
    cloud.z[i] = static_cast<float>(points[i].z());
    cloud.pixels[i] = i;
  }
  cut_to(cloud, cloud.size());
  return cloud;
}

}  // namespace knuckle
