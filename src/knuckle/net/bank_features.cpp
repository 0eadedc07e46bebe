// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/bank_features.h"

#include "knuckle/net/layers/map_operations.h"

namespace knuckle {
namespace {

FeatureMap square_map(int size, int channels) {
  return FeatureMap({.height = size, .width = size, .channels = channels});
}

/// Adds a map to the features, map by map.
void append(const FeatureMap& map, std::vector<float>& features) {
  for (int channel = 0; channel < map.channels(); ++channel) {
    for (int row = 0; row < map.height(); ++row) {
      for (int column = 0; column < map.width(); ++column) {
        features.push_back(map.pixel(row, column)[channel]);
      }
    }
  }
}

}  // namespace

BankFeatures::BankFeatures(const NetworkWeights& weights)
    : patch_size_(weights.options().patch.size_px), pool_([this] { return make_maps(); }) {
  int number = 0;
  for (const auto& bank : kBankLayers) {
    std::vector<Layer>& layers = banks_.emplace_back();
    int inputs = 1;
    int outputs = weights.options().paper.first_maps;
    for (const BankLayer& layer : bank) {
      const std::string name = "banks.convolution" + std::to_string(number++);
      const Convolution::Shape shape{.inputs = inputs, .outputs = outputs, .kernel = layer.kernel};
      const int input_stride = layers.empty() ? 1 : whole_lanes(inputs);
      layers.push_back(
          {Convolution(shape, input_stride, weights.floats(name + ".weight"), weights.floats(name + ".bias")),
           layer.pool});
      inputs = outputs;
      outputs = weights.options().paper.second_maps;
    }
  }
}

BankFeatures::Maps BankFeatures::make_maps() const {
  Maps maps;
  int bank_size = patch_size_;
  for (const std::vector<Layer>& bank : banks_) {
    BankMaps& bank_maps = maps.emplace_back(BankMaps{FeatureMap::of_image(bank_size, 0), {}});
    int size = bank_size;
    for (const Layer& layer : bank) {
      const int channels = layer.convolution.shape().outputs;
      const int convolved = layer.convolution.output_size(size);
      size = convolved / layer.pool;
      bank_maps.layers.push_back({square_map(convolved, channels), square_map(size, channels)});
    }
    bank_size /= 2;
  }
  return maps;
}

std::vector<float> BankFeatures::features_of(const Image<float>& patch) const {
  return pool_.with_workspace([&](Maps& maps) {
    std::vector<float> features;
    copy_image(patch, maps[0].input);
    for (std::size_t b = 0; b < banks_.size(); ++b) {
      if (b > 0) halve(maps[b - 1].input, maps[b].input);
      const FeatureMap* input = &maps[b].input;
      for (std::size_t i = 0; i < banks_[b].size(); ++i) {
        LayerMaps& layer = maps[b].layers[i];
        // The largest of the rectified values is the rectified largest.
        banks_[b][i].convolution.apply(*input, layer.convolved, Activation::relu);
        max_pool(layer.convolved, banks_[b][i].pool, layer.pooled);
        input = &layer.pooled;
      }
      append(*input, features);
    }
    return features;
  });
}

}  // namespace knuckle
