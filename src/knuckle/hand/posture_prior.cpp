// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/posture_prior.h"

#include "knuckle/hand/posture_table.h"

namespace knuckle {
namespace {

PosturePrior prior_of_table() {
  PosturePrior prior;
  for (int i = 0; i < kHandAngleCount; ++i) {
    prior.mean[i] = kMeanPosture[i];
    for (int k = 0; k <= i; ++k) prior.precision(i, k) = prior.precision(k, i) = kPosturePrecision[i][k];
  }
  return prior;
}

AngleVector away(const HandAngles& angles, const AngleVector& mean) {
  return Eigen::Map<const AngleVector>(angles.radians.data()) - mean;
}

}  // namespace

double PosturePrior::squared_distance(const HandAngles& angles) const {
  return away(angles, mean).dot(half_gradient(angles));
}

AngleVector PosturePrior::half_gradient(const HandAngles& angles) const {
  return precision * away(angles, mean);
}

const PosturePrior& sampled_postures() {
  static const PosturePrior prior = prior_of_table();
  return prior;
}

}  // namespace knuckle
