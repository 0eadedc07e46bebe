// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <memory>

#include <torch/nn/module.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>

namespace knuckle {

/// Convolution (padded to keep the size, without bias), batch norm, and ReLU where wanted.
class ConvolutionUnit final : public torch::nn::Module {
 public:
  enum class Activation { relu, none };
  /// Channels, kernel and stride [px].
  struct Shape {
    int inputs = 1;
    int outputs = 1;
    int kernel = 3;
    int stride = 1;
  };

  explicit ConvolutionUnit(const Shape& shape, Activation activation = Activation::relu);
  torch::Tensor forward(const torch::Tensor& input);

 private:
  torch::nn::Conv2d convolution_{nullptr};
  torch::nn::BatchNorm2d norm_{nullptr};
  Activation activation_;
};

/// Two 3 x 3 convolutions beside a shortcut (He et al. 2016).
class ResidualBlock final : public torch::nn::Module {
 public:
  explicit ResidualBlock(int channels);
  torch::Tensor forward(const torch::Tensor& input);

 private:
  std::shared_ptr<ConvolutionUnit> first_;
  std::shared_ptr<ConvolutionUnit> second_;
};

/// Each pixel four times: N x C x 2h x 2w.
torch::Tensor twice_as_large(const torch::Tensor& input);

}  // namespace knuckle
