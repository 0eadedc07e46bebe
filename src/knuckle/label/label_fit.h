// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/hand/hand_surface.h"
#include "knuckle/label/label_change.h"
#include "knuckle/label/person_bones.h"

namespace knuckle {

/// How much a hand's labels count when a skeleton is fitted to them.
struct LabelFitOptions {
  /// Deviation of a visible landmark that a person answers for: that of a click, (0, inf) [mm]
  double pin_mm = 2.0;
  /// Of a hidden one: a person can only guess it, (0, inf) [mm]
  double guess_mm = 8.0;
  double estimate_mm = 5.0;  ///< of one that was estimated or propagated, (0, inf) [mm]
  /// Of an estimate on a digit of which a landmark was corrected: where one is wrong, its neighbours are
  /// likely wrong as well, (0, inf) [mm].
  double beside_pin_mm = 8.0;
  /// Estimates are less sure along the line of sight: the squared ratio of both deviations, (0, 1]
  double estimate_depth_weight = 0.2;
};

/// What is known of a hand beside its own labels.
struct LabelFitContext {
  const PersonBones* bones = nullptr;        ///< of the person; null: those of all people
  std::optional<SkeletonPose> start = {};    ///< where the fit begins; the last one's answer spares time
  std::optional<HandAngles> expected = {};   ///< angles that neighbouring frames speak for
  std::optional<std::size_t> left_out = {};  ///< a landmark whose label does not count
  double expected_rad = 0.2;                 ///< how far they may be from it, (0, inf) [rad]
};

/// A skeleton fitted to a hand's labels.
struct LabelFit {
  SkeletonPose pose;               ///< of a right hand: a left one's in the mirror
  std::vector<ImagePoint> points;  ///< one per landmark of the convention; missing where a skeleton has none
  double rms_mm = 0.0;             ///< as in SkeletonFit
  double gap_mm = kNaN;            ///< as in SkeletonFit
};

/// Fits an adult's skeleton to the labels of a hand and to the depth image: pinned landmarks hold it, others
/// follow depth, limits and what was estimated (`estimates`, one per landmark: where the estimator saw them,
/// not where a fit put them). A landmark that is hidden and not pinned says nothing: it comes from the model
/// alone. Landmarks outside of the 22 neither count nor come. Nothing where fewer than three are known.
/// `frame` is as the camera took it, `side` the hand's.
std::optional<LabelFit> fit_labels(const Frame& frame, HandSide side, const Convention& convention,
                                   const std::vector<LandmarkLabel>& labels,
                                   const std::vector<ImagePoint>& estimates, const LabelFitContext& context,
                                   const LabelFitOptions& options = {});

/// The labels with what a fit says: landmarks that a person answers for stay, all others move to the fit's
/// points and become `state`.
std::vector<LandmarkLabel> with_fit(std::vector<LandmarkLabel> labels, const LabelFit& fit, LabelState state);

}  // namespace knuckle
