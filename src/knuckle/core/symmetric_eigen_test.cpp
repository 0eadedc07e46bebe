// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/symmetric_eigen.h"

#include <limits>

#include <gtest/gtest.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// Symmetric and of full rank, with numbers of both signs.
Eigen::MatrixXd example(int size) {
  Eigen::MatrixXd matrix(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) matrix(i, j) = 1.0 / (i + j + 1) - (i == j && i % 2 == 0 ? 2.0 : 0.0);
  }
  return matrix;
}

TEST(SymmetricEigen, IsTheMatrixAgain) {
  const Eigen::MatrixXd matrix = example(7);
  const SymmetricEigen eigen = symmetric_eigen(matrix);
  const Eigen::MatrixXd again = eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose();
  EXPECT_LT((again - matrix).norm(), 1e-12);
  EXPECT_LT((eigen.vectors.transpose() * eigen.vectors - Eigen::MatrixXd::Identity(7, 7)).norm(), 1e-12);
  for (int k = 1; k < 7; ++k) EXPECT_LE(eigen.values[k - 1], eigen.values[k]);
}

TEST(SymmetricEigen, ReadsTheLowerHalfAlone) {
  const Eigen::MatrixXd lower = example(5).triangularView<Eigen::Lower>();
  EXPECT_EQ(symmetric_eigen(lower).values, symmetric_eigen(example(5)).values);
}

TEST(SymmetricEigen, NumbersThatAreNotFiniteAreAnError) {
  Eigen::MatrixXd matrix = example(3);
  matrix(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(symmetric_eigen(matrix), Error);
}

}  // namespace
}  // namespace knuckle
