// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>

#include <torch/types.h>

namespace knuckle {

/// The sizes of a convolution (without padding) and of the max-pooling after it.
struct PooledConvolutionShape {
  int kernel = 1;
  int pool = 1;
};

/// relu(max_pool(convolution(maps))): N x C x H x W -> N x outputs x h x w, stored pixel by pixel.
/// `weight`: outputs x C x kernel x kernel.
///
/// On a processor, in single precision, it is worked on sample by sample, so that what lies between
/// convolution and pooling stays in the cache and is never stored: only the largest of each pool passes its
/// gradient on, so the way back touches one place of pool x pool, and none where the rectifier is shut.
/// Elsewhere these are LibTorch's own operations.
torch::Tensor pooled_convolution(const torch::Tensor& maps, const torch::Tensor& weight,
                                 const torch::Tensor& bias, const PooledConvolutionShape& shape);

}  // namespace knuckle
