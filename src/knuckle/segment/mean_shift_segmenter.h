// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "knuckle/segment/mean_shift.h"
#include "knuckle/segment/ray_cache.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

/// Mean-shift hand segmentation (Riegler et al. 2015, eq. 2): the hand is what lies within the kernel's reach
/// of the fixed point found from the start.
struct MeanShiftSegmenterOptions {
  MeanShiftOptions mean_shift;
  double kernel_cutoff = 1e-5;  ///< A point is hand where exp(-|x - centre| / h) exceeds this, (0, 1): 155 mm
  double min_area_mm2 =
      1500.0;  ///< Smaller regions are no hands, [0, 1e6] [mm^2]; a fist seen end-on has 3000
  double max_area_mm2 =
      40000.0;  ///< Larger ones neither, (0, 1e6] [mm^2]; a spread hand and its wrist have 22000
  double separation_mm =
      50.0;                 ///< Points that near to a region found belong to no other hand, [0, 1000] [mm]
  int max_candidates = 10;  ///< Nearest places tried before giving up, [1, 1000]

  void visit(OptionVisitor& visitor);
};

/// Starts at the given point, or at the nearest pixel after a 5x5 median (nearest_pixel.h). What it finds is
/// no hand where its area (of its pixels, each taken parallel to the image) is below `min_area_mm2`: a
/// speckle nearer than the hand. Nor above `max_area_mm2`: the trunk of a body, or a wall, that a speckle
/// beside it led to. Where no start was given, the speckle is then taken out and the search goes on at the
/// nearest pixel of the rest; a given start is trusted: the upper bound does not hold there, and nothing else
/// is tried in its place. For further hands the regions found are taken out with all points within
/// `separation_mm` of their ball.
///
/// A search has a fixed budget of points, whatever the size of the image (search_image.h): a large image is
/// thinned for it, and a start that was not given is followed over few of the points first. Without a hand (a
/// wall) that is all; a hand's centre is the fixed point over all points of the thinned image, and its pixels
/// are those of the whole one.
///
/// Score: the kernel-weighted area over that of an unbounded plane through the centre, facing the camera
/// (2 pi h^2). About 1 for the flat of a hand, less for a finger, the border of the image, or sparse
/// measurements.
class MeanShiftSegmenter final : public Segmenter {
 public:
  /// Throws an Error where an option is out of range.
  explicit MeanShiftSegmenter(const MeanShiftSegmenterOptions& options);

  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override;

 private:
  MeanShiftSegmenterOptions options_;
  mutable RayCache ray_cache_;
};

}  // namespace knuckle
