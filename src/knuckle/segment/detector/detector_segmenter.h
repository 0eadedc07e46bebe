// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/segment/detector/hand_detector.h"
#include "knuckle/segment/ray_cache.h"
#include "knuckle/segment/segmenter.h"

namespace knuckle {

/// The `[segmentation]` table of the method "detector", beside `model`.
struct DetectorSegmenterOptions {
  DetectionOptions detection;
  double margin_mm = 25.0;       ///< What is that far beyond the extent still is hand, [0, 500] [mm]
  double min_area_mm2 = 1500.0;  ///< Smaller regions are no hands, [0, 1e6] [mm^2]
  bool cut_surface = true;       ///< A table or a wall behind a hand does not belong to its region

  void visit(OptionVisitor& visitor);
};

/// A hand is what is measured in the ball around a detected centre, of the hand's extent and a margin. No
/// assumption of what is nearest. Centre, side and score are the detector's. The surface that the hand is
/// seen before (surface_behind.h) is left out, unless what remains is smaller than a hand.
///
/// A given start is trusted: the region is that around the surest hand whose centre is at most 80 mm from it,
/// else around the start itself, with the extent of a hand that is half open and a score of 0.01.
class DetectorSegmenter final : public Segmenter {
 public:
  /// Throws an Error where an option is out of range.
  DetectorSegmenter(const DetectorWeights& weights, const DetectorSegmenterOptions& options);

  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override;

 private:
  /// Adds the region of a hand, or says why it is none.
  void add_region(const Frame& frame, const DetectedHand& hand, bool is_given, Segmentation& result) const;

  HandDetector detector_;
  DetectorSegmenterOptions options_;
  mutable RayCache ray_cache_;
};

}  // namespace knuckle
