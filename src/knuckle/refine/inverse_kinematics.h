// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/options.h"
#include "knuckle/hand/skeleton_fit.h"
#include "knuckle/refine/refiner.h"

namespace knuckle {

/// Options of `InverseKinematics`; the defaults are those of SkeletonFitOptions.
struct InverseKinematicsOptions {
  double noise_mm = 4.0;        ///< deviation of a joint of confidence 1, (0, 1000] [mm]
  double posture_spread = 1.0;  ///< factor on how much the angles differ between postures, (0, 100]
  double size_spread = 0.12;    ///< of the hand's size around an adult's, [0, 1]; 0: an adult's
  bool fill = true;             ///< joints that were not found come from the skeleton

  void visit(OptionVisitor& visitor);
};

/// Makes the joints those of a hand with bones and limits: an adult's skeleton, of a size of its own in each
/// frame, fitted to them by `fit_skeleton`; the paper's inverse kinematics (Riegler et al. 2015, section 3,
/// postprocessing). The joints' confidences are the weights, and stay as they are. The depth image is not
/// asked. Sees a right hand, as all of a pipeline does. A pose with fewer than three known joints of the
/// superset comes back unchanged, as do joints that a skeleton does not have.
class InverseKinematics final : public Refiner {
 public:
  explicit InverseKinematics(const InverseKinematicsOptions& options);
  RefinedHand refine(const Frame& frame, const HandRegion& hand, HandPose pose) const override;

 private:
  InverseKinematicsOptions options_;
};

}  // namespace knuckle
