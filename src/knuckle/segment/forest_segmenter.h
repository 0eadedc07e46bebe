// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/forest/pixel_forest.h"
#include "knuckle/segment/ray_cache.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

/// Segmentation by a random forest (Riegler et al. 2015, section 3, equation 1).
struct ForestSegmenterOptions {
  double probability = 0.8;  ///< A pixel is hand where the forest is surer than this, [0, 1)
  int median_px = 3;         ///< Side of the median filter over these pixels; odd, 1: none, [1, 31] [px]
  int closing_px = 3;        ///< Side of the square that closes gaps; odd, 1: none, [1, 31] [px]
  int opening_px = 1;        ///< Side of the square that removes what is thinner; odd, 1: none, [1, 31] [px]
  /// Pixels beside a step down of more than this (or beside no measurement) are no hand: sensors mix depths
  /// there; 0: all stay, [0, 1000] [mm]
  double edge_step_mm = 0.0;
  double min_area_mm2 = 1500.0;  ///< Smaller components are no hands, [0, 1e6] [mm^2]

  void visit(OptionVisitor& visitor);
};

/// The forest gives each measured pixel a probability; those above the threshold pass a median filter, a
/// closing and an opening. What was not measured is dropped again, and where asked the edge of the hand. Each
/// 8-connected component is a hand.
///
/// Centre: mean of the points. Score: the area [mm^2]. Best
/// is the highest score; where a start is given, what lies nearest to it (the score decides between
/// components that hold points within 20 mm of it).
class ForestSegmenter final : public Segmenter {
 public:
  /// Throws an Error where an option is out of range.
  ForestSegmenter(PixelForest forest, const ForestSegmenterOptions& options);

  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override;

 private:
  PixelForest forest_;
  ForestSegmenterOptions options_;
  mutable RayCache ray_cache_;
};

}  // namespace knuckle
