// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/paper_architecture.h"

#include <array>
#include <string_view>
#include <utility>

#include "knuckle/core/named_table.h"

namespace knuckle {
namespace {

using Layers = std::vector<ConnectedLayer>;
using enum ConnectedLayer::Activation;

ConnectedLayer wide(const NetworkOptions& options) {
  return {options.paper.hidden_units, hidden};
}

ConnectedLayer joints(const NetworkOptions& options) {
  return {3 * options.joint_count(), linear};
}

Layers heat_map_layers(const NetworkOptions& options) {
  const int cells = options.paper.map_cells * options.paper.map_cells;
  return {wide(options), {options.joint_count() * (cells + depth_bins_per_joint(options)), linear}};
}

Layers regression_layers(const NetworkOptions& options) {
  return {wide(options), wide(options), joints(options)};
}

Layers pca_layers(const NetworkOptions& options) {
  return {wide(options), wide(options), {options.paper.subspace_units, linear}, joints(options)};
}

Layers autoencoder_layers(const NetworkOptions& options) {
  return {wide(options), wide(options), {options.paper.subspace_units, relu}, wide(options), joints(options)};
}

struct PaperNetwork {
  std::string_view name;
  Layers (*layers)(const NetworkOptions& options);
};

constexpr std::array kPaperNetworks{
    PaperNetwork{"heatmap2d", heat_map_layers},      PaperNetwork{"heatmap25d", heat_map_layers},
    PaperNetwork{"regression", regression_layers},   PaperNetwork{"pca", pca_layers},
    PaperNetwork{"autoencoder", autoencoder_layers},
};

}  // namespace

int bank_feature_count(int patch_size, int second_maps) {
  int count = 0;
  for (const auto& bank : kBankLayers) {
    int size = patch_size;
    for (const BankLayer& layer : bank) size = (size - layer.kernel + 1) / layer.pool;
    count += second_maps * size * size;
    patch_size /= 2;
  }
  return count;
}

int depth_bins_per_joint(const NetworkOptions& options) {
  return options.architecture == "heatmap25d" ? options.paper.depth_bins : 0;
}

std::vector<ConnectedLayer> connected_layers(const NetworkOptions& options) {
  return row_named(kPaperNetworks, options.architecture)->layers(options);
}

std::vector<NetworkArray> paper_arrays(const NetworkOptions& options) {
  using enum NetworkArray::Precision;
  std::vector<NetworkArray> arrays;
  const auto add = [&](const std::string& name, std::vector<int> shape) {
    const int outputs = shape.front();
    arrays.push_back({name + ".weight", std::move(shape), half});
    arrays.push_back({name + ".bias", {outputs}, half});
  };
  int number = 0;
  for (const auto& bank : kBankLayers) {
    int inputs = 1;
    int outputs = options.paper.first_maps;
    for (const BankLayer& layer : bank) {
      add("banks.convolution" + std::to_string(number++), {outputs, inputs, layer.kernel, layer.kernel});
      inputs = outputs;
      outputs = options.paper.second_maps;
    }
  }
  int inputs = bank_feature_count(options.patch.size_px, options.paper.second_maps);
  number = 0;
  for (const ConnectedLayer& layer : connected_layers(options)) {
    const std::string name = "layers.layer" + std::to_string(number++);
    if (layer.has_norm()) {
      arrays.push_back({name + ".linear.weight", {layer.units, inputs}, half});
      add_norm(arrays, name + ".norm", layer.units);
    } else {
      add(name + ".linear", {layer.units, inputs});
    }
    inputs = layer.units;
  }
  return arrays;
}

}  // namespace knuckle
