// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "knuckle/hand/hand_angles.h"

namespace knuckle {

using AngleVector = Eigen::Matrix<double, kHandAngleCount, 1>;
using AngleMatrix = Eigen::Matrix<double, kHandAngleCount, kHandAngleCount>;

/// What postures are likely before a hand is seen: a normal distribution of all its angles together, so that
/// a finger that is hidden bends as its neighbours do.
struct PosturePrior {
  AngleVector mean = AngleVector::Zero();           ///< [rad]
  AngleMatrix precision = AngleMatrix::Identity();  ///< inverse of the covariance [1/rad^2]

  /// How improbable angles are: the squared distance of Mahalanobis from the mean, 22 on average.
  double squared_distance(const HandAngles& angles) const;
  /// Half of its derivatives by the angles; half of the second ones are `precision`.
  AngleVector half_gradient(const HandAngles& angles) const;
};

/// Learned from the postures that the generator's sampler draws for its training sets (right hands, and left
/// ones seen in a mirror): scripts/fit_posture_prior.py writes its table.
const PosturePrior& sampled_postures();

}  // namespace knuckle
