// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "knuckle/core/landmarks.h"

namespace knuckle {

/// A point in camera coordinates [mm]: x right, y down, z forward.
using Point3 = Eigen::Vector3d;

/// What stands for a coordinate that is not known.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A point of the image with its depth: the paper's u = (u, v, d). (u, v) = (i, j) is the centre of pixel
/// (column i, row j). A point that is not known is NaN in all three.
struct ImagePoint {
  double u = kNaN;         ///< column [px]
  double v = kNaN;         ///< row [px]
  double depth_mm = kNaN;  ///< [mm]

  bool is_missing() const { return !(std::isfinite(u) && std::isfinite(v) && std::isfinite(depth_mm)); }
};

/// Joints of one hand in the image.
struct HandPose {
  Convention convention;
  std::vector<ImagePoint> joints;  ///< one per landmark of the convention; missing ones are NaN
  std::vector<float> confidence;   ///< one per joint in [0, 1], or empty where the method gives none

  /// A pose of which nothing is known: all joints NaN.
  static HandPose missing(const Convention& convention);
  /// True where not one joint is known.
  bool is_missing() const;
};

/// The mean of the joints that are known, in the image; missing where none is.
ImagePoint mean_joint(const HandPose& pose);

/// The same pose in another convention: shared landmarks are kept, those the source lacks are missing.
HandPose converted(const HandPose& pose, const Convention& target);

/// The pose seen in a mirrored image that is `width` pixels wide: u becomes width - 1 - u.
HandPose mirrored(const HandPose& pose, int width);

}  // namespace knuckle
