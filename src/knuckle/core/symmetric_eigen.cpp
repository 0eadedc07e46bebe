// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/symmetric_eigen.h"

#include <Eigen/Eigenvalues>

#include "knuckle/core/error.h"

namespace knuckle {

// Here alone: each file that calls Eigen's solver itself takes as long to compile as ten others.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  if (solver.info() != Eigen::Success) {
    fail("the eigenvalues of a {} x {} matrix did not converge", matrix.rows(), matrix.cols());
  }
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace knuckle
