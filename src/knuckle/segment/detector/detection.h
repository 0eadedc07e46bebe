// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/core/options.h"
#include "knuckle/core/pose.h"
#include "knuckle/segment/detector/detector_view.h"

namespace knuckle {

/// A hand that a detector saw.
struct DetectedHand {
  Point3 centre = Point3::Zero();  ///< the mean of its landmarks, in camera coordinates [mm]
  double extent_mm = 0.0;          ///< from the centre to the farthest landmark
  double score = 0.0;              ///< how sure the detector is of it, (0, 1)
  HandSide side = HandSide::right;
  double side_confidence = 0.5;  ///< how sure it is of the side, [0.5, 1)
};

/// Which peaks of a heat map are hands.
struct DetectionOptions {
  double min_score = 0.4;       ///< What is less sure is no hand, [0, 1]
  double separation_mm = 60.0;  ///< No two centres are nearer; the surer one stays, [0, 1000] [mm]

  void visit(OptionVisitor& visitor);
};

/// The maps that a detector's network gives: kDetectorMaps numbers per cell, row by row.
struct DetectorMaps {
  int width = 0;
  int height = 0;
  std::vector<float> values;

  const float* cell(int column, int row) const {
    return values.data() + (static_cast<std::size_t>(row) * width + column) * kDetectorMaps;
  }
};

/// The hands in a network's maps, the surest first: cells that no neighbour of the eight exceeds (of equal
/// ones the first counts), surer than asked, none near a surer one.
std::vector<DetectedHand> hands_in(const DetectorMaps& maps, const DetectorView& view,
                                   const DetectionOptions& options);

}  // namespace knuckle
