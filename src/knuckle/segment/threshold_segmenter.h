// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/segment/ray_cache.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

/// Depth thresholding (Riegler et al. 2015, section 3).
struct ThresholdSegmenterOptions {
  std::string interval =
      "nearest";            ///< "nearest": [d_nearest, d_nearest + range_mm]; "fixed": [near_mm, far_mm]
  double range_mm = 300.0;  ///< The paper's t_t, (0, 10000] [mm]
  double tolerance_mm =
      15.0;                ///< Pixels that much nearer than d_nearest still belong (noise), [0, 1000] [mm]
  double near_mm = 100.0;  ///< Of the fixed interval, [0, 20000] [mm]
  double far_mm = 600.0;   ///< Above near_mm, (0, 20000] [mm]
  std::string pixels =
      "all";  ///< "all" in the interval are the hand; "component": each connected part is one
  double min_area_mm2 = 1500.0;  ///< Smaller regions are no hands, [0, 1e6] [mm^2]

  void visit(OptionVisitor& visitor);
};

/// d_nearest is the smallest depth after a 5x5 median (nearest_pixel.h), so that single stray pixels are not
/// the hand; where a start is given, the interval is centred on its depth instead. The fixed interval needs
/// neither.
///
/// With `pixels = "all"`, as in the paper, all pixels in the interval are one hand: there is at most one.
/// With "component" each 8-connected component is a hand of its own, the largest areas first.
///
/// Where nothing in the nearest interval is large enough, its pixels are speckles: they are left out and the
/// nearest of the rest is tried.
///
/// Centre: mean of the points. Score: the area [mm^2].
class ThresholdSegmenter final : public Segmenter {
 public:
  /// Throws an Error where an option is out of range.
  explicit ThresholdSegmenter(const ThresholdSegmenterOptions& options);

  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override;

 private:
  std::vector<HandRegion> hands_between(const Frame& frame, const Image<float>& depth_mm, double near_mm,
                                        double far_mm, int max_hands) const;
  HandRegion region_of(const std::vector<std::int32_t>& pixels, const Frame& frame) const;

  ThresholdSegmenterOptions options_;
  mutable RayCache ray_cache_;
};

}  // namespace knuckle
