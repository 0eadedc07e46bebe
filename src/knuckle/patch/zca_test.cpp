// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/zca.h"

#include <Eigen/Eigenvalues>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::knuckle::testing::error_of;
using ::testing::HasSubstr;

/// Correlated samples: neighbours share noise.
Eigen::MatrixXd correlated_samples(int count, int size) {
  Random random(4);
  Eigen::MatrixXd samples(count, size);
  for (int i = 0; i < count; ++i) {
    double last = 0.0;
    for (int k = 0; k < size; ++k) samples(i, k) = last = 0.9 * last + random.normal() + 0.3 * k;
  }
  return samples;
}

TEST(Zca, GivesTheSamplesTheIdentityAsCovariance) {
  const Eigen::MatrixXd samples = correlated_samples(4000, 16);
  const Eigen::MatrixXd whitening = zca_matrix(samples, 1e-9);
  const Eigen::MatrixXd white = (samples.rowwise() - samples.colwise().mean()) * whitening.transpose();
  const Eigen::MatrixXd covariance = white.transpose() * white / (samples.rows() - 1);
  EXPECT_LT((covariance - Eigen::MatrixXd::Identity(16, 16)).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Zca, IsSymmetricAndPositive) {
  const Eigen::MatrixXd whitening = zca_matrix(correlated_samples(500, 12), 0.01);
  EXPECT_LT((whitening - whitening.transpose()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(whitening).eigenvalues().minCoeff(), 0.0);
}

TEST(Zca, BoundsDirectionsWithoutVariance) {
  Eigen::MatrixXd samples = correlated_samples(100, 8);
  samples.col(3).setConstant(5.0);
  const Eigen::MatrixXd whitening = zca_matrix(samples, 0.25);
  EXPECT_NEAR(whitening(3, 3), 2.0, 1e-9);  // 1 / sqrt(0.25)
  EXPECT_TRUE(zca_matrix(correlated_samples(3, 8), 0.1).allFinite());
}

TEST(Zca, OfPatchesIsThatOfTheirPixels) {
  const Eigen::MatrixXd samples = correlated_samples(50, 9);
  std::vector<Image<float>> patches;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    patches.emplace_back(3, 3);
    for (int k = 0; k < 9; ++k) patches.back().data()[k] = static_cast<float>(samples(i, k));
  }
  const std::vector<float> whitening = zca_whitening(patches, 0.1);
  const Eigen::MatrixXd expected = zca_matrix(samples, 0.1);
  ASSERT_EQ(whitening.size(), 81u);
  for (int k = 0; k < 81; ++k) EXPECT_NEAR(whitening[k], expected(k / 9, k % 9), 1e-4);
}

TEST(Zca, RefusesWhatItCannotWhiten) {
  EXPECT_THAT(error_of([] { (void)zca_matrix(Eigen::MatrixXd(1, 4), 0.1); }), HasSubstr("1 samples"));
  EXPECT_THAT(error_of([] { (void)zca_matrix(Eigen::MatrixXd::Ones(3, 4), 0.0); }),
              HasSubstr("epsilon is 0"));
  EXPECT_THAT(error_of([] { (void)zca_matrix(Eigen::MatrixXd::Constant(3, 4, NAN), 0.1); }),
              HasSubstr("finite"));
  EXPECT_THAT(error_of([] { (void)zca_whitening({}, 0.1); }), HasSubstr("no patch"));
  EXPECT_THAT(error_of([] {
                (void)zca_whitening({Image<float>(3, 3), Image<float>(3, 4)}, 0.1);
              }),
              HasSubstr("patch 1 is 3 x 4"));
}

}  // namespace
}  // namespace knuckle
