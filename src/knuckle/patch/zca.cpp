// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/zca.h"

#include <cmath>

#include "knuckle/core/error.h"
#include "knuckle/core/symmetric_eigen.h"

namespace knuckle {

Eigen::MatrixXd zca_matrix(const Eigen::MatrixXd& samples, double epsilon) {
  if (samples.rows() < 2) fail("whitening: {} samples, expected at least 2", samples.rows());
  if (!samples.allFinite()) fail("whitening: a sample holds a value that is not finite");
  if (!(epsilon > 0.0) || !std::isfinite(epsilon))
    fail("whitening: epsilon is {}, expected above 0", epsilon);
  const Eigen::MatrixXd centred = samples.rowwise() - samples.colwise().mean();
  const Eigen::MatrixXd covariance = centred.transpose() * centred / static_cast<double>(samples.rows() - 1);
  const SymmetricEigen eigen = symmetric_eigen(covariance);
  // Rounding may leave eigenvalues a little below 0.
  const Eigen::VectorXd scales = (eigen.values.array().max(0.0) + epsilon).rsqrt();
  return eigen.vectors * scales.asDiagonal() * eigen.vectors.transpose();
}

std::vector<float> zca_whitening(const std::vector<Image<float>>& patches, double epsilon) {
  if (patches.empty()) fail("whitening: there is no patch");
  Eigen::MatrixXd samples(patches.size(), patches.front().size());
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const Image<float>& patch = patches[static_cast<std::size_t>(i)];
    if (patch.width() != patches.front().width() || patch.height() != patches.front().height()) {
      fail("whitening: patch {} is {} x {} pixels, the first one {} x {}", i, patch.width(), patch.height(),
           patches.front().width(), patches.front().height());
    }
    samples.row(i) = Eigen::Map<const Eigen::RowVectorXf>(patch.data(), samples.cols()).cast<double>();
  }
  const Eigen::MatrixXf whitening = zca_matrix(samples, epsilon).cast<float>();
  return std::vector<float>(whitening.data(), whitening.data() + whitening.size());
}

}  // namespace knuckle
