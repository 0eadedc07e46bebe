// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <span>

#include "knuckle/net/layers/activation.h"
#include "knuckle/net/layers/aligned_vector.h"
#include "knuckle/net/layers/feature_map.h"
#include "knuckle/net/layers/winograd_tiles.h"

namespace knuckle {

/// A convolution of 3 x 3 that keeps the size, tile by tile with fewer multiplications than by the
/// definition: Lavin and Gray, "Fast Algorithms for Convolutional Neural Networks", CVPR 2016, section 4.
/// `Tile`: Tile2 or Tile4.
template <class Tile>
class WinogradConvolution {
 public:
  /// `weights`: outputs x inputs x 3 x 3; `bias`: outputs. `input_stride`: numbers per pixel of the input
  /// map, whole registers.
  WinogradConvolution(int inputs, int outputs, int input_stride, std::span<const float> weights,
                      std::span<const float> bias);

  /// `input` has a border of at least one pixel; `output` its size; `added` may be `output` itself, or null.
  /// Safe to be called by many threads at once; each keeps its workspace.
  void apply(const FeatureMap& input, FeatureMap& output, Activation activation,
             const FeatureMap* added) const;

 private:
  struct Strip;
  struct Workspace;

  /// Everything that the sums need, for all outputs.
  void transform_inputs(const Strip& strip, Workspace& workspace) const;
  /// The outputs from `first_output` on, so many vectors.
  template <int kVectors>
  void apply_block(const Strip& strip, Workspace& workspace, int first_output) const;
  template <int kVectors>
  void write_outputs(const Strip& strip, const Workspace& workspace, int first_output) const;

  int outputs_;
  int input_stride_;
  AlignedVector weights_;  // as weights_in_blocks orders them, for the points of a transformed tile
  AlignedVector bias_;
};

extern template class WinogradConvolution<Tile2>;
extern template class WinogradConvolution<Tile4>;

}  // namespace knuckle
