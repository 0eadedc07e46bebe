// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/convolution_banks.h"

#include <span>
#include <string>

#include <torch/nn/init.h>
#include <torch/utils.h>

#include "knuckle/net/paper_architecture.h"

namespace knuckle {

ConvolutionBanks::ConvolutionBanks(int patch_size, int first_maps, int second_maps)
    : feature_count_(bank_feature_count(patch_size, second_maps)) {
  for (const auto& bank : kBankLayers) {
    int inputs = 1;
    int outputs = first_maps;
    for (const BankLayer& shape : bank) {
      const std::string name = "convolution" + std::to_string(layers_.size());
      layers_.push_back({register_module(name, torch::nn::Conv2d(inputs, outputs, shape.kernel)),
                         {shape.kernel, shape.pool}});
      torch::nn::init::kaiming_normal_(layers_.back().convolution->weight, 0.0, torch::kFanIn, torch::kReLU);
      torch::nn::init::zeros_(layers_.back().convolution->bias);
      inputs = first_maps;
      outputs = second_maps;
    }
  }
}

torch::Tensor ConvolutionBanks::forward(const torch::Tensor& patches) {
  torch::Tensor scaled = patches;
  std::vector<torch::Tensor> features;
  for (std::size_t i = 0; i < layers_.size(); i += 2) {
    torch::Tensor maps = scaled;
    for (const Layer& layer : std::span(layers_).subspan(i, 2)) {
      const torch::nn::Conv2dImpl& convolution = *layer.convolution;
      maps = pooled_convolution(maps, convolution.weight, convolution.bias, layer.shape);
    }
    features.push_back(maps.flatten(1));
    scaled = torch::avg_pool2d(scaled, {2, 2});
  }
  return torch::cat(features, 1);
}

}  // namespace knuckle
