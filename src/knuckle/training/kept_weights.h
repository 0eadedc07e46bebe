// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <torch/types.h>

namespace knuckle {

/// The rows and columns of a matrix of weights that belong to the units a dropout kept: rows.size() x
/// columns.size(). Both are ascending indices; one that is not defined stands for all. Differentiable in
/// `weight`.
torch::Tensor kept_weights(const torch::Tensor& weight, const torch::Tensor& rows,
                           const torch::Tensor& columns);

}  // namespace knuckle
