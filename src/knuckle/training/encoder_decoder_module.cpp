// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/encoder_decoder_module.h"

#include <string>

#include <torch/nn/init.h>
#include <torch/utils.h>

namespace knuckle {

EncoderDecoderModule::EncoderDecoderModule(torch::nn::Module& owner, const EncoderDecoderShape& shape) {
  const auto unit = [&](const std::string& name, const ConvolutionUnit::Shape& of_unit) {
    return owner.register_module(name, std::make_shared<ConvolutionUnit>(of_unit));
  };
  const int channels[] = {shape.stem, shape.quarter, shape.eighth, shape.sixteenth};
  down_.push_back(unit("stem", {shape.inputs, channels[0], 5, 2}));
  for (int stage = 1; stage <= kEncoderStages; ++stage) {
    down_.push_back(unit("down" + std::to_string(stage), {channels[stage - 1], channels[stage], 3, 2}));
    auto& blocks = blocks_.emplace_back();
    for (int i = 0; i < shape.blocks; ++i) {
      const std::string name = "block" + std::to_string(stage) + "_" + std::to_string(i);
      blocks.push_back(owner.register_module(name, std::make_shared<ResidualBlock>(channels[stage])));
    }
  }
  lateral_ = {unit("lateral2", {channels[3], channels[2], 1, 1}),
              unit("lateral1", {channels[2], channels[1], 1, 1})};
  smooth_ = {unit("smooth2", {channels[2], channels[2], 3, 1}),
             unit("smooth1", {channels[1], shape.head, 3, 1})};
  const torch::nn::Conv2dOptions head(shape.head, shape.maps, 1);
  head_ = owner.register_module("head", torch::nn::Conv2d(head));
  torch::nn::init::normal_(head_->weight, 0.0, 0.01);
  torch::nn::init::zeros_(head_->bias);
}

torch::Tensor EncoderDecoderModule::forward(const torch::Tensor& inputs) {
  torch::Tensor features = down_[0]->forward(inputs.contiguous(torch::MemoryFormat::ChannelsLast));
  std::vector<torch::Tensor> stages;
  for (std::size_t stage = 0; stage < blocks_.size(); ++stage) {
    features = down_[stage + 1]->forward(features);
    for (const auto& block : blocks_[stage]) features = block->forward(features);
    stages.push_back(features);
  }
  for (std::size_t i = 0; i < lateral_.size(); ++i) {
    const torch::Tensor coarse = twice_as_large(lateral_[i]->forward(features));
    features = smooth_[i]->forward(coarse + stages[1 - i]);
  }
  return head_->forward(features.to(head_->weight.scalar_type()));
}

}  // namespace knuckle
