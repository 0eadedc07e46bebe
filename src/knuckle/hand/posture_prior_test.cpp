// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/posture_prior.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "knuckle/core/testing.h"
#include "knuckle/hand/skeleton_testing.h"

namespace knuckle {
namespace {

using enum HandAngle;

int column(HandAngle angle) {
  return static_cast<int>(angle);
}

AngleMatrix covariance() {
  return sampled_postures().precision.inverse();
}

double correlation(HandAngle a, HandAngle b) {
  const AngleMatrix of = covariance();
  return of(column(a), column(b)) / std::sqrt(of(column(a), column(a)) * of(column(b), column(b)));
}

HandAngles angles_at(const AngleVector& values) {
  HandAngles angles;
  for (int i = 0; i < kHandAngleCount; ++i) angles.radians[i] = values[i];
  return angles;
}

TEST(PosturePrior, IsANormalDistributionOfHandsThatHandsCanTake) {
  const PosturePrior& prior = sampled_postures();
  EXPECT_TRUE(prior.precision.isApprox(prior.precision.transpose()));
  EXPECT_EQ(prior.precision.llt().info(), Eigen::Success) << "positive definite";
  EXPECT_TRUE(within_limits(angles_at(prior.mean)));
  EXPECT_EQ(prior.squared_distance(angles_at(prior.mean)), 0.0);
  for (int i = 0; i < kHandAngleCount; ++i) {
    const double deviation = std::sqrt(covariance()(i, i));
    EXPECT_GT(deviation, 0.04) << i;
    EXPECT_LT(deviation, 0.8) << "no angle of a hand is as free as it was without: " << i;
  }
}

TEST(PosturePrior, DistancesHaveTheMeanThatTheDistributionSays) {
  const AngleMatrix root = Eigen::LLT<AngleMatrix>(covariance()).matrixL();
  Random random(1);
  double sum = 0.0;
  constexpr int kMany = 2000;
  for (int trial = 0; trial < kMany; ++trial) {
    AngleVector normal;
    for (double& value : normal) value = random.normal();
    sum += sampled_postures().squared_distance(angles_at(sampled_postures().mean + root * normal));
  }
  // Chi squared with 22 degrees of freedom: the deviation of this mean is sqrt(44 / 2000) = 0.15.
  EXPECT_NEAR(sum / kMany, kHandAngleCount, 0.75);
}

TEST(PosturePrior, TheGradientIsThatOfFiniteDifferences) {
  Random random(2);
  const HandAngles angles = testing::random_angles(healthy_limits(), random);
  const AngleVector gradient = sampled_postures().half_gradient(angles);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < kHandAngleCount; ++i) {
    HandAngles more = angles;
    HandAngles less = angles;
    more.radians[i] += kStep;
    less.radians[i] -= kStep;
    const double slope =
        (sampled_postures().squared_distance(more) - sampled_postures().squared_distance(less)) /
        (4.0 * kStep);
    EXPECT_NEAR(gradient[i], slope, 1e-6 * gradient.norm());
  }
}

TEST(PosturePrior, FingersBendTogether) {
  EXPECT_GT(correlation(middle_pip, ring_pip), 0.6);
  EXPECT_GT(correlation(middle_mcp, ring_mcp), 0.6);
  EXPECT_GT(correlation(index_pip, index_dip), 0.8) << "the tendons' coupling";
  EXPECT_LT(std::abs(correlation(thumb_ip, little_mcp)), 0.4) << "the thumb goes its own way";
}

}  // namespace
}  // namespace knuckle
