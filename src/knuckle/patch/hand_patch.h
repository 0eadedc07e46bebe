// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// A point in the coordinates of a patch: u and v run from -1 (centre of the first pixel) to 1 (centre of the
/// last), d is the depth in standard deviations from the hand's mean depth.
struct PatchPoint {
  double u = kNaN;
  double v = kNaN;
  double d = kNaN;
};

/// How patch coordinates and image coordinates belong together. Both directions are exact inverses.
struct PatchGeometry {
  int size_px = 0;        ///< width and height of the patch
  double centre_u = 0.0;  ///< image position of the patch's centre [px]
  double centre_v = 0.0;
  double image_px_per_patch_px = 1.0;
  double mean_depth_mm = 0.0;  ///< over the hand's pixels
  double depth_deviation_mm = 1.0;

  PatchPoint to_patch(const ImagePoint& point) const;
  ImagePoint to_image(const PatchPoint& point) const;
};

/// What an estimator sees: the hand, cut out, resized and normalised.
struct HandPatch {
  Image<float> pixels;  ///< size_px x size_px; depth in deviations, background at +3 before mean subtraction
  PatchGeometry geometry;
  Camera camera;  ///< of the frame that it was cut out of
};

}  // namespace knuckle
