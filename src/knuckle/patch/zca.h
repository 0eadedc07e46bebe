// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "knuckle/core/image.h"

namespace knuckle {

/// Zero component analysis (Bell and Sejnowski 1997): the symmetric matrix W = U (L + epsilon)^(-1/2) U^T
/// with C = U L U^T the covariance of the samples, so that W (x - mean) has the covariance 1 (less where L is
/// not far above `epsilon`). `samples`: one per row, at least 2, all finite; `epsilon` above 0 keeps
/// directions without variance from being blown up. The time is that of an eigenvalue decomposition, cubic in
/// the number of columns.
Eigen::MatrixXd zca_matrix(const Eigen::MatrixXd& samples, double epsilon);

/// The whitening of PatchStatistics from a training set's patches, all of one size.
std::vector<float> zca_whitening(const std::vector<Image<float>>& patches, double epsilon);

}  // namespace knuckle
