// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/hand_region.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr int kMostHands = 16;

Box box_around(const std::vector<std::int32_t>& pixels, int width) {
  int left = pixels.front() % width;
  int right = left;
  int top = pixels.front() / width;
  int bottom = top;
  for (const std::int32_t pixel : pixels) {
    left = std::min(left, pixel % width);
    right = std::max(right, pixel % width);
    top = std::min(top, pixel / width);
    bottom = std::max(bottom, pixel / width);
  }
  return Box{left, top, right - left + 1, bottom - top + 1};
}

}  // namespace

HandRegion region_of_pixels(const std::vector<std::int32_t>& pixels, int width) {
  assert(!pixels.empty());
  HandRegion region;
  region.box = box_around(pixels, width);
  region.mask = Image<std::uint8_t>(region.box.width, region.box.height);
  for (const std::int32_t pixel : pixels) {
    region.mask(pixel % width - region.box.x, pixel / width - region.box.y) = 1;
  }
  return region;
}

HandRegion mirrored(HandRegion region, int width) {
  region.box.x = width - region.box.right();
  region.mask = mirrored(region.mask);
  region.centre.x() = -region.centre.x();
  if (region.side) region.side = *region.side == HandSide::left ? HandSide::right : HandSide::left;
  if (region.right_hand) region.right_hand = 1.0 - *region.right_hand;
  return region;
}

HandRegion region_in_cube(const Frame& frame, const Point3& centre, double side_mm) {
  const Projection projection(frame.camera);
  const ImagePoint middle = projection.to_image(centre);
  const double half_px = 0.5 * side_mm * projection.pixels_per_mm(centre.z());
  const auto nearest_mm = static_cast<float>(centre.z() - 0.5 * side_mm);
  const auto farthest_mm = static_cast<float>(centre.z() + 0.5 * side_mm);
  const auto first = [](double place, int size) {
    return static_cast<int>(std::clamp(std::ceil(place), 0.0, static_cast<double>(size)));
  };
  const int width = frame.depth_mm.width();
  const int height = frame.depth_mm.height();
  std::vector<std::int32_t> pixels;
  for (int row = first(middle.v - half_px, height); row < first(middle.v + half_px, height); ++row) {
    for (int column = first(middle.u - half_px, width); column < first(middle.u + half_px, width); ++column) {
      const float depth = frame.depth_mm(column, row);
      if (is_measured(depth) && depth >= nearest_mm && depth <= farthest_mm) {
        pixels.push_back(row * width + column);
      }
    }
  }
  HandRegion region = pixels.empty() ? HandRegion() : region_of_pixels(pixels, width);
  region.centre = centre;
  return region;
}

double pixel_area_mm2(const Camera& camera, double depth_mm) {
  const double area_at_unit_depth = 1.0 / std::abs(camera.fx * camera.fy);
  return camera.model == CameraModel::orthographic ? area_at_unit_depth
                                                   : area_at_unit_depth * depth_mm * depth_mm;
}

double area_mm2(const std::vector<std::int32_t>& pixels, const Camera& camera, const Image<float>& depth_mm) {
  double area = 0.0;
  for (const std::int32_t pixel : pixels) area += pixel_area_mm2(camera, depth_mm.data()[pixel]);
  return area;
}

Point3 mean_point(const std::vector<std::int32_t>& pixels, const RayTable& rays,
                  const Image<float>& depth_mm) {
  Point3 sum = Point3::Zero();
  for (const std::int32_t pixel : pixels) {
    const int column = pixel % depth_mm.width();
    const int row = pixel / depth_mm.width();
    const float depth = depth_mm.data()[pixel];
    sum += Point3(rays.x(column, row, depth), rays.y(column, row, depth), depth);
  }
  return sum / static_cast<double>(pixels.size());
}

void check_max_hands(int max_hands) {
  if (max_hands < 1 || max_hands > kMostHands)
    fail("max_hands is {}, expected [1, {}]", max_hands, kMostHands);
}

void check_start(const Frame& frame, const std::optional<Point3>& start) {
  if (start && !start->allFinite()) {
    fail("frame {}: the start of the segmentation must be finite, not ({}, {}, {})", frame.name, start->x(),
         start->y(), start->z());
  }
}

void check_size(const Frame& frame) {
  const Image<float>& depth = frame.depth_mm;
  if (depth.empty()) return;
  if (depth.width() != frame.camera.width || depth.height() != frame.camera.height) {
    fail("frame {}: the depth image is {} x {} pixels, its camera {} x {}", frame.name, depth.width(),
         depth.height(), frame.camera.width, frame.camera.height);
  }
}

}  // namespace knuckle
