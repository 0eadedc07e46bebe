// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/net/network_weights.h"

namespace knuckle {

/// A convolution without padding, and the max-pooling after it.
struct BankLayer {
  int kernel;
  int pool;
};

/// One for each size of the patch.
inline constexpr int kBanks = 3;
/// Convolutions, each with its pooling.
inline constexpr int kLayersPerBank = 2;
/// Of each bank its two layers, from the patch to a quarter of it (Tompson et al. 2014).
inline constexpr BankLayer kBankLayers[kBanks][kLayersPerBank] = {
    {{5, 4}, {6, 2}}, {{5, 2}, {5, 2}}, {{4, 1}, {4, 2}}};

/// How many numbers the banks end in: 7776 for patches of 96 pixels and 32 maps, 9 x 9 x 32 from each bank.
int bank_feature_count(int patch_size, int second_maps);

/// A fully connected layer after the banks.
struct ConnectedLayer {
  enum class Activation { hidden, relu, linear };  ///< hidden: ReLU, in training with dropout
  int units;
  Activation activation;

  /// Layers with a ReLU have a batch norm before it, in place of a bias.
  bool has_norm() const { return activation != Activation::linear; }
};

/// Heat maps: numbers per joint in the output, cells and, in `heatmap25d`, bins of depth.
int depth_bins_per_joint(const NetworkOptions& options);

/// The layers of one of the paper's five architectures.
std::vector<ConnectedLayer> connected_layers(const NetworkOptions& options);

/// Their arrays, as `network_arrays` has them.
std::vector<NetworkArray> paper_arrays(const NetworkOptions& options);

}  // namespace knuckle
