// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/layers.h"

#include <torch/nn/functional/upsampling.h>
#include <torch/nn/init.h>
#include <torch/utils.h>

#include "knuckle/net/layers/batch_norm.h"

namespace knuckle {
namespace {

torch::nn::Conv2dOptions padded(const ConvolutionUnit::Shape& shape) {
  return torch::nn::Conv2dOptions(shape.inputs, shape.outputs, shape.kernel)
      .stride(shape.stride)
      .padding(shape.kernel / 2)
      .bias(false);
}

}  // namespace

ConvolutionUnit::ConvolutionUnit(const Shape& shape, Activation activation)
    : convolution_(register_module("convolution", torch::nn::Conv2d(padded(shape)))),
      norm_(register_module(
          "norm", torch::nn::BatchNorm2d(torch::nn::BatchNorm2dOptions(shape.outputs).eps(kNormEpsilon)))),
      activation_(activation) {
  torch::nn::init::kaiming_normal_(convolution_->weight, 0.0, torch::kFanOut, torch::kReLU);
}

torch::Tensor ConvolutionUnit::forward(const torch::Tensor& input) {
  // Computed in the input's type whatever that of the weights.
  const torch::Tensor weight = convolution_->weight.to(input.scalar_type());
  const auto& options = convolution_->options;
  const torch::Tensor sums = torch::conv2d(input, weight, {}, options.stride(), weight.size(2) / 2);
  torch::Tensor result = norm_->forward(sums);
  return activation_ == Activation::relu ? torch::relu_(result) : result;
}

ResidualBlock::ResidualBlock(int channels)
    : first_(register_module("first",
                             std::make_shared<ConvolutionUnit>(ConvolutionUnit::Shape{channels, channels}))),
      second_(register_module("second",
                              std::make_shared<ConvolutionUnit>(ConvolutionUnit::Shape{channels, channels},
                                                                ConvolutionUnit::Activation::none))) {}

torch::Tensor ResidualBlock::forward(const torch::Tensor& input) {
  return torch::relu_(second_->forward(first_->forward(input)).add_(input));
}

torch::Tensor twice_as_large(const torch::Tensor& input) {
  return torch::upsample_nearest2d(input, {2 * input.size(2), 2 * input.size(3)});
}

}  // namespace knuckle
