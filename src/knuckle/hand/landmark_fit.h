// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/hand/landmark_definition.h"

namespace knuckle {

/// One frame to fit a definition to: what was estimated, and what people say.
struct LabelledPoints {
  SupersetPoints estimated;  ///< in camera coordinates [mm]
  HandSide side = HandSide::right;
  std::vector<Point3> labelled;  ///< one per landmark of the convention [mm]; one that is not known is NaN
};

/// How far estimates are from the labels of one landmark, on average [mm]; NaN where no frame knows it.
struct LandmarkFitScore {
  std::int64_t frames = 0;     ///< that know it
  double before_mm = kNaN;     ///< from the landmark's bone itself
  double after_mm = kNaN;      ///< with offsets that were fitted to all frames
  double validated_mm = kNaN;  ///< each part of the frames with offsets that were fitted to the other parts
};

/// A definition that was fitted, and how much it explains.
struct LandmarkFit {
  LandmarkDefinition definition;
  std::vector<LandmarkFitScore> landmarks;  ///< one per landmark of the convention
  LandmarkFitScore all;                     ///< over all landmarks of all frames
};

inline constexpr int kFitParts = 5;             ///< of the cross-validation: contiguous parts of the frames
inline constexpr int kFewestFittedFrames = 10;  ///< that know a landmark
/// How strongly offsets are drawn to those of the start [1 / palm length]: as by a third of a frame that is a
/// tenth of a palm's length off.
inline constexpr double kStartWeight = 3.0;

/// Fits six numbers per landmark, its offset in the axes of its bone where the finger is straight and where
/// it is folded back (`DefinedLandmark::bent`), so that the sum of the distances between labels and moved
/// estimates, and of kStartWeight / 2 times the squared distances of the offsets from those of `start`, is
/// least, by iteratively reweighted least squares (Weiszfeld 1937): a few frames that were estimated wrong
/// hardly move it, and what few frames tell stays near the start. What the estimates always do wrong is taken
/// in as well. A landmark that fewer than kFewestFittedFrames frames know stays as it is. Parts of the
/// cross-validation are contiguous: neighbouring frames are alike. Throws an Error where no landmark is known
/// in enough frames, or a frame has another number of labels than the convention.
LandmarkFit fit_landmarks(const LandmarkDefinition& start, std::span<const LabelledPoints> frames);

}  // namespace knuckle
