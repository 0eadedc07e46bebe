// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "knuckle/camera/projection.h"
#include "knuckle/core/image.h"

namespace knuckle {

/// Points in camera coordinates [mm], coordinate by coordinate, for loops that take kLanes points at once: up
/// to padded_size() the arrays are filled with points so far away that no kernel sees them. They may be
/// longer still.
struct PointCloud {
  static constexpr int kLanes = 8;  ///< floats in an AVX register

  Eigen::ArrayXf x;
  Eigen::ArrayXf y;
  Eigen::ArrayXf z;
  std::vector<std::int32_t> pixels;  ///< of each point its pixel, row * image width + column
  int thinning = 1;                  ///< how many measured pixels each point stands for

  int size() const { return static_cast<int>(pixels.size()); }  ///< points, without those that fill up
  int padded_size() const { return (size() + kLanes - 1) / kLanes * kLanes; }
};

/// The measured points of a depth image within `radius_mm` of `centre` (camera coordinates, mm), row by row.
/// `rays` has the size of the image. Where more than `most` (above 0) pixels have a depth in that interval,
/// only each k-th of them is looked at, with the smallest k that leaves no more.
PointCloud points_around(const Image<float>& depth_mm, const RayTable& rays, const Point3& centre,
                         double radius_mm, int most = std::numeric_limits<int>::max());

/// A cloud of given points; point i gets the pixel i.
PointCloud cloud_of(const std::vector<Point3>& points);

}  // namespace knuckle
