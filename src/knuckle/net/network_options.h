// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "knuckle/core/landmarks.h"
#include "knuckle/core/options.h"
#include "knuckle/patch/patch_extractor.h"

namespace knuckle {

/// Patches' sizes are multiples of it: the stride of the coarsest features, in all architectures.
inline constexpr int kNetworkStride = 16;

/// Names of all architectures.
std::span<const std::string_view> network_architectures();

/// The encoder-decoder `dense`: a stem at half the patch's resolution, stages at a quarter, an eighth and a
/// sixteenth, and two steps up again, each with the stage's own features added.
struct DenseNetworkOptions {
  int stem_channels = 16;        ///< [1, 1024]
  int quarter_channels = 32;     ///< [1, 1024]
  int eighth_channels = 64;      ///< [1, 1024]
  int sixteenth_channels = 128;  ///< [1, 1024]
  int head_channels = 64;        ///< before the maps, [1, 1024]
  int blocks = 1;                ///< residual blocks a stage, [1, 16]
  double kernel = 0.8;           ///< reach of the closeness, in halves of the cube's side, (0, 4]
  double dense_weight = 0.5;     ///< of the loss on offsets and closeness against that on joints, [0, 100]
  bool tells_side = false;  ///< one more map says whether the hand is a right one, as joints are told for
  bool tells_hand = false;  ///< one more map says whether there is a hand at all
  /// Of the entropy of each of both answers in the loss, against the joints' distances, [0, 100].
  double question_weight = 0.05;

  void visit(OptionVisitor& visitor);
};

/// The paper's five networks (Riegler et al. 2015, section 4): three banks of convolutions on the patch, a
/// half and a quarter of it, as in Tompson et al. 2014, then fully connected layers.
struct PaperNetworkOptions {
  int first_maps = 16;            ///< of a bank's first convolution, [1, 1024]
  int second_maps = 32;           ///< of its second, [1, 1024]
  int hidden_units = 4096;        ///< of each hidden fully connected layer, [1, 65536]
  int subspace_units = 20;        ///< of the bottleneck of `pca` and `autoencoder`, [1, 65536]
  double dropout = 0.5;           ///< share of the hidden units that is left out in training, [0, 1)
  int map_cells = 18;             ///< width and height of a heat map, [4, 256]
  int depth_bins = 25;            ///< of a joint in `heatmap25d`, [3, 1024]
  double peak_deviation = 1.0;    ///< of the targets' Gaussians, [0.5, 10] [cells]
  std::string peak = "gaussian";  ///< gaussian | mean_shift: how a map's peak is found

  void visit(OptionVisitor& visitor);
};

/// A network and what it sees and predicts: all that is needed to build it.
struct NetworkOptions {
  std::string architecture = "dense";    ///< dense | heatmap2d | heatmap25d | regression | pca | autoencoder
  std::string convention = "knuckle22";  ///< landmarks that it predicts, as `convention_text` has them
  PatchOptions patch{.size_px = 96, .mode = "cube", .cube_mm = 250.0};
  DenseNetworkOptions dense;  ///< of the architecture "dense" alone
  PaperNetworkOptions paper;  ///< of the five others

  /// The `[network]` table: all but the patch, and only what the architecture reads.
  void visit(OptionVisitor& visitor);
  /// The landmarks that it predicts. Throws an Error where `convention` says none.
  const Convention& landmarks() const;
  int joint_count() const { return landmarks().size(); }
};

/// Throws an Error that starts with `what` where an option is out of range, or the parts do not fit together.
void check(const NetworkOptions& options, std::string_view what);

/// The options as TOML, and back. `origin` stands for the file's name in errors.
std::string network_options_as_toml(const NetworkOptions& options);
/// Reads the options back.
NetworkOptions network_options_from_toml(std::string_view toml, const std::string& origin);

}  // namespace knuckle
