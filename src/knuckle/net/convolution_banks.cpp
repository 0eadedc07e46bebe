// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/convolution_banks.h"

#include <span>
#include <string>

#include <torch/nn/init.h>
#include <torch/utils.h>

namespace knuckle {
namespace {

struct LayerShape {
  int kernel;
  int pool;
};

/// Of each bank its two layers, from the patch to a quarter of it.
constexpr LayerShape kBanks[3][2] = {{{5, 4}, {6, 2}}, {{5, 2}, {5, 2}}, {{4, 1}, {4, 2}}};

}  // namespace

ConvolutionBanks::ConvolutionBanks(int patch_size, int first_maps, int second_maps) {
  int bank_size = patch_size;
  for (const auto& bank : kBanks) {
    int inputs = 1;
    int outputs = first_maps;
    int64_t size = bank_size;
    for (const LayerShape& shape : bank) {
      const std::string name = "convolution" + std::to_string(layers_.size());
      layers_.push_back(
          {register_module(name, torch::nn::Conv2d(inputs, outputs, shape.kernel)), shape.pool});
      torch::nn::init::kaiming_normal_(layers_.back().convolution->weight, 0.0, torch::kFanIn, torch::kReLU);
      torch::nn::init::zeros_(layers_.back().convolution->bias);
      size = (size - shape.kernel + 1) / shape.pool;
      inputs = first_maps;
      outputs = second_maps;
    }
    feature_count_ += second_maps * size * size;
    bank_size /= 2;
  }
}

torch::Tensor ConvolutionBanks::forward(const torch::Tensor& patches) {
  torch::Tensor scaled = patches;
  std::vector<torch::Tensor> features;
  for (std::size_t i = 0; i < layers_.size(); i += 2) {
    torch::Tensor maps = scaled;
    for (Layer& layer : std::span(layers_).subspan(i, 2)) {
      // The largest of the rectified values is the rectified largest.
      maps = torch::relu(torch::max_pool2d(layer.convolution->forward(maps), {layer.pool, layer.pool}));
    }
    features.push_back(maps.flatten(1));
    scaled = torch::avg_pool2d(scaled, {2, 2});
  }
  return torch::cat(features, 1);
}

}  // namespace knuckle
