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
  double pin_mm = 1.0;       ///< deviation of a landmark that a person answers for, (0, inf) [mm]
  double estimate_mm = 8.0;  ///< of one that was estimated or propagated, (0, inf) [mm]
  /// Of an estimate on a digit of which a landmark was corrected: where one is wrong, its neighbours are
  /// likely wrong as well, (0, inf) [mm].
  double beside_pin_mm = 30.0;
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

/// How deep the landmark lies below the skin that is seen before it [mm], of a hand whose palm is that long:
/// medians of the generator's people. 0 outside of the 22.
double depth_below_skin_mm(Landmark landmark, double palm_mm);

/// Where the skin of a hand may be [mm].
struct SkinDepths {
  double near_mm = 0.0;
  double far_mm = 1e9;
};

/// The depths at which a hand's skin may be seen whose landmarks lie there; any where fewer than three are
/// known.
SkinDepths skin_depths(const std::vector<ImagePoint>& landmarks);

/// The depth of the skin that a person shows on a pixel [mm]: of what was measured around it, the nearest to
/// the pixel that may be skin, so that one who points beside a finger does not get the wall behind it.
/// Nothing where none was within 6 px.
std::optional<double> skin_depth_at(const Frame& frame, double u, double v, const SkinDepths& depths);

/// Where a landmark lies that a person shows on a pixel: as deep as the skin there (`skin_depth_at`), and
/// what lies between skin and joint. Without a measurement, `depth_mm` is kept. Missing where neither is
/// known.
ImagePoint placed_on_pixel(const Frame& frame, double u, double v, Landmark landmark, double palm_mm,
                           double depth_mm, const SkinDepths& depths = {});

/// The depth of a landmark that was shown on a pixel [mm]: between what was measured there and where the hand
/// model has it, which knows the rest of the hand. The farther both are apart, the less the measurement
/// counts (Geman and McClure 1985): another finger may lie before the joint.
double settled_depth_mm(double measured_mm, double fitted_mm);

}  // namespace knuckle
