// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <vector>

#include <torch/nn/module.h>
#include <torch/nn/modules/conv.h>

#include "knuckle/training/pooled_convolution.h"

namespace knuckle {

/// The multi-resolution features of Tompson et al. 2014, as the paper uses them: three banks of two
/// convolutions (without padding), each followed by a ReLU and a max-pooling, on the patch, a half and a
/// quarter of it.
class ConvolutionBanks final : public torch::nn::Module {
 public:
  ConvolutionBanks(int patch_size, int first_maps, int second_maps);

  /// N x 1 x size x size -> N x feature_count().
  torch::Tensor forward(const torch::Tensor& patches);
  /// 7776 for patches of 96 pixels and 32 maps: 9 x 9 from each bank.
  int64_t feature_count() const { return feature_count_; }

 private:
  struct Layer {
    torch::nn::Conv2d convolution;
    PooledConvolutionShape shape;
  };

  std::vector<Layer> layers_;  // two a bank
  int64_t feature_count_;
};

}  // namespace knuckle
