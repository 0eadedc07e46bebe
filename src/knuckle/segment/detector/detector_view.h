// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"
#include "knuckle/segment/detector/detector_options.h"

namespace knuckle {

/// Where something is in the small picture.
struct ViewPlace {
  double u = 0.0;              ///< column [cells]; the centre of the first cell is 0
  double v = 0.0;              ///< row [cells]
  double inverse_depth = 0.0;  ///< as the network knows it [1/m]
};

/// What the network sees of a frame: height x width cells.
struct DetectorInput {
  /// Of the second nearest of nine places in the cell (the nearest may be a flying pixel), times the view's
  /// scale, cut to [0, kMostInverseDepth] [1/m]; 0 where nothing was measured.
  Image<float> inverse_depth;
  Image<float> measured_share;  ///< of the nine places, [0, 1]
};

inline constexpr double kMostInverseDepth = 10.0;  ///< of something 100 mm away [1/m]

/// The small picture that a detector sees of one camera's frames. It is the picture of a pinhole camera with
/// the network's own focal length, whatever the camera's: a hand of one size at one distance always covers as
/// many cells. The middle of the frame's field of view lies in the middle.
///
/// A field wider than the picture is shrunk by `scale` below 1. Depths are then divided by it, so that
/// what is as many cells wide is as many millimetres wide still, and only depth relief is stretched. Of a
/// field wider than 1 / kSmallestScale times the picture (122 degrees) the outer part is not seen. An
/// orthographic camera's picture is that of a pinhole camera for what is a metre away.
class DetectorView {
 public:
  static constexpr double kSmallestScale = 0.4;

  /// Throws an Error where the camera's values are impossible.
  DetectorView(const DetectorOptions& options, const Camera& camera);

  const Camera& camera() const { return camera_; }
  double scale() const { return scale_; }

  /// A point in camera coordinates with z above 0 [mm], and back.
  ViewPlace to_view(const Point3& point) const;
  Point3 to_camera(const ViewPlace& place) const;

  /// Shrinks a depth image of the camera's size [mm]. What it costs does not depend on the image's size.
  DetectorInput shrink(const Image<float>& depth_mm) const;

 private:
  void center_on_field();
  void choose_samples();
  /// x over z (of an orthographic camera over 1 m) in a column; y over z in a row.
  double ray_x(double u) const;
  double ray_y(double v) const;

  DetectorOptions options_;
  Camera camera_;
  double sign_x_;  // of the focal lengths: the picture is turned as the image is
  double sign_y_;
  double scale_ = 1.0;
  double middle_x_ = 0.0;  // ray through the picture's middle
  double middle_y_ = 0.0;
  std::vector<std::int32_t> samples_;  // nine planes of a pixel per cell, -1 outside the image
};

}  // namespace knuckle
