// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/point_cloud.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>

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

/// Numbers of the pixels with a depth in [low, high], in order.
std::vector<std::int32_t> pixels_between(const Image<float>& depth_mm, float low, float high) {
  // Most pixels are out of the interval, in long runs: eight flags at once say whether there is one to look
  // at.
  const std::size_t size = depth_mm.size();
  std::vector<std::uint8_t> flags((size + 7) / 8 * 8);
  const float* const depth = depth_mm.data();
  int count = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const int is_between = static_cast<int>(depth[i] >= low) & static_cast<int>(depth[i] <= high);
    flags[i] = static_cast<std::uint8_t>(is_between);
    count += is_between;
  }
  std::vector<std::int32_t> pixels(static_cast<std::size_t>(count) + 1);  // one more is written and dropped
  std::int32_t* next = pixels.data();
  for (std::size_t i = 0; i < flags.size(); i += 8) {
    std::uint64_t eight_flags = 0;
    std::memcpy(&eight_flags, &flags[i], sizeof(eight_flags));
    if (eight_flags == 0) continue;
    for (std::size_t k = i; k < i + 8; ++k) {
      *next = static_cast<std::int32_t>(k);
      next += flags[k];
    }
  }
  pixels.pop_back();
  return pixels;
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
  const auto low = std::max(static_cast<float>(centre.z() - radius_mm), std::numeric_limits<float>::min());
  const auto high = std::min(static_cast<float>(centre.z() + radius_mm), std::numeric_limits<float>::max());
  std::vector<std::int32_t> pixels = pixels_between(depth_mm, low, high);
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
