// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/synth/rasteriser.h"

namespace knuckle {

/// Cosine of the angle between line of sight and surface normal at each pixel, [0, 1]; 0 where nothing is
/// seen. Exact: from the plane of the face that the pixel shows. The line of sight meets the plane n p = h
/// (n of length 1) at p = z r, where r is the pixel's ray with depth 1, so the cosine is h / (z |r|).
Image<float> surface_cosines(const Rendering& rendering, const TriangleMesh& mesh, const Camera& camera);

/// Length of each pixel's ray, from the camera to depth 1, at least 1: row by row. 1 for all pixels of an
/// orthographic camera.
class RayLengths {
 public:
  explicit RayLengths(const Camera& camera);
  float operator()(int column, int row) const;

 private:
  bool is_distorted_;
  Image<float> lengths_;   ///< of a distorted camera
  std::vector<float> x2_;  ///< squares of the rays' x for each column, and of y for each row, otherwise
  std::vector<float> y2_;
};

}  // namespace knuckle
