// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/paper_architecture.h"

namespace knuckle {

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
  using enum ConnectedLayer::Activation;
  const ConnectedLayer wide{options.paper.hidden_units, hidden};
  const ConnectedLayer joints{3 * options.joint_count(), linear};
  const int subspace = options.paper.subspace_units;
  if (options.architecture.starts_with("heatmap")) {
    const int cells = options.paper.map_cells * options.paper.map_cells;
    return {wide, {options.joint_count() * (cells + depth_bins_per_joint(options)), linear}};
  }
  if (options.architecture == "pca") return {wide, wide, {subspace, linear}, joints};
  if (options.architecture == "autoencoder") return {wide, wide, {subspace, relu}, wide, joints};
  return {wide, wide, joints};
}

}  // namespace knuckle
