// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// The paper's projection phi: image points with depth to points in camera coordinates, and back.
///
/// Projective: x = (u - cx) d / fx, y = (v - cy) d / fy, z = d, with OpenCV's distortion between.
/// Orthographic: x = (u - cx) / fx, y = (v - cy) / fy, z = d. A missing (NaN) point stays missing.
class Projection {
 public:
  /// Throws an Error where the camera's values are impossible.
  explicit Projection(const Camera& camera);

  const Camera& camera() const { return camera_; }

  /// phi. The depth is the distance along z; of a depth of 0 or below nothing sensible comes back.
  Point3 to_camera(const ImagePoint& point) const;
  /// phi'. A projective camera maps points with z <= 0 to a missing point.
  ImagePoint to_image(const Point3& point) const;

  std::vector<Point3> to_camera(const std::vector<ImagePoint>& points) const;
  std::vector<ImagePoint> to_image(const std::vector<Point3>& points) const;

  /// How many pixels along u one millimetre across the view covers at this depth.
  double pixels_per_mm(double depth_mm) const;

 private:
  Camera camera_;
  bool is_distorted_;
};

/// The rays of all pixels of a camera, computed once: x and y of the point that a pixel sees at depth 1
/// (projective), or at any depth (orthographic). Makes clouds from depth images without undistorting again.
class RayTable {
 public:
  explicit RayTable(const Camera& camera);

  const Camera& camera() const { return camera_; }
  float x(int column, int row, float depth_mm) const {
    return rays_x_(column, row) * (is_orthographic_ ? 1.0f : depth_mm);
  }
  float y(int column, int row, float depth_mm) const {
    return rays_y_(column, row) * (is_orthographic_ ? 1.0f : depth_mm);
  }
  const Image<float>& rays_x() const { return rays_x_; }
  const Image<float>& rays_y() const { return rays_y_; }

 private:
  Camera camera_;
  bool is_orthographic_;
  Image<float> rays_x_;
  Image<float> rays_y_;
};

}  // namespace knuckle
