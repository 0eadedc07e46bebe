// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/options.h"
#include "knuckle/hand/skeleton_fit.h"
#include "knuckle/refine/refiner.h"

namespace knuckle {

/// Options of `HandModel`.
struct HandModelOptions {
  double noise_mm = 4.0;        ///< deviation of a joint of confidence 1, (0, 1000] [mm]
  double bone_mm = 5.0;         ///< of the way from a digit's joint to the next, [0, 1000] [mm]; 0: not asked
  double posture_spread = 1.0;  ///< factor on how much the angles differ between postures, (0, 100]
  double size_spread = 0.12;    ///< of the hand's size around an adult's, [0, 1]; 0: an adult's
  double length_spread = 0.07;  ///< of the lengths of the digits' bones, [0, 1]; 0: an adult's
  double surface_mm = 2.3;      ///< of all measured points together from the skin, (0, 1000] [mm]
  /// Of how deep digits run into one another beyond 6 mm, [0, 1000] [mm]; 0: not asked.
  double overlap_mm = 2.0;
  bool fill = true;  ///< joints that were not found come from the skeleton

  void visit(OptionVisitor& visitor);
};

/// Makes the joints those of a hand that agrees with the estimate and with the depth image: an adult's
/// skeleton with flesh, of a size of its own in each frame, fitted by `fit_skeleton` to the joints, weighted
/// by their confidences, and to the points measured near them (Oikonomidis et al. 2011 and Tagliasacchi et
/// al. 2015 fit hands to depth in this way; the paper's [25] and [26]). Confidences stay as they are; what
/// fits no hand well is less plausible. Sees a right hand, as all of a pipeline does. A pose with fewer than
/// three known joints of the superset comes back unchanged, as do joints that a skeleton does not have.
class HandModel final : public Refiner {
 public:
  explicit HandModel(const HandModelOptions& options);
  RefinedHand refine(const Frame& frame, const HandRegion& hand, HandPose pose) const override;

 private:
  HandModelOptions options_;
};

}  // namespace knuckle
