// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace knuckle {

/// A symmetric matrix taken apart: matrix = vectors * diag(values) * transpose of vectors.
struct SymmetricEigen {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< orthonormal, a column per value
};

/// Eigenvalues and eigenvectors of a symmetric matrix (n x n), of which only the lower half is read. Throws
/// an Error where they are not found, as for numbers that are not finite.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);

}  // namespace knuckle
