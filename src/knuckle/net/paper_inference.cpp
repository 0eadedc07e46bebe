// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/paper_inference.h"

#include "knuckle/net/heat_map_decoding.h"

namespace knuckle {
namespace {

FullyConnectedLayer layer_of(const NetworkWeights& weights, const std::string& name, int inputs,
                             const ConnectedLayer& layer) {
  const std::span<const Half> products = weights.halves(name + ".linear.weight");
  if (layer.has_norm()) {
    const FoldedNorm norm = folded_norm(weights, name + ".norm");
    return {inputs, layer.units, Activation::relu, products, norm};
  }
  const std::vector<float> biases = weights.floats(name + ".linear.bias");
  const FoldedNorm none{std::vector(biases.size(), 1.0), {biases.begin(), biases.end()}};
  return {inputs, layer.units, Activation::linear, products, none};
}

}  // namespace

PaperInference::PaperInference(const NetworkWeights& weights) : options_(weights.options()), banks_(weights) {
  int inputs = bank_feature_count(options_.patch.size_px, options_.paper.second_maps);
  for (const ConnectedLayer& layer : connected_layers(options_)) {
    const std::string name = "layers.layer" + std::to_string(layers_.size());
    layers_.push_back(layer_of(weights, name, inputs, layer));
    inputs = layer.units;
  }
}

NetworkPrediction PaperInference::predict(const Image<float>& patch) const {
  std::vector<float> values = banks_.features_of(patch);
  for (const FullyConnectedLayer& layer : layers_) values = layer.apply(values);
  if (options_.architecture.starts_with("heatmap")) {
    return decode_heat_maps(options_, values, patch.pixels());
  }
  NetworkPrediction prediction;
  for (std::size_t i = 0; i < values.size(); i += 3) {
    prediction.joints.push_back({values[i], values[i + 1], values[i + 2]});
  }
  return prediction;
}

}  // namespace knuckle
