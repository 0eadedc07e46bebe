// SPDX-License-Identifier: Apache-2.0
// Private to the modules of networks.
#pragma once

#include <span>
#include <variant>

#include "knuckle/net/layers/activation.h"
#include "knuckle/net/layers/aligned_vector.h"
#include "knuckle/net/layers/feature_map.h"
#include "knuckle/net/layers/winograd_convolution.h"

namespace knuckle {

/// A convolution with its bias, and what follows it: output = activation(convolution(input) + bias + added).
class Convolution {
 public:
  /// Channels, size of the kernel, and steps.
  struct Shape {
    int inputs = 1;
    int outputs = 1;
    int kernel = 3;
    int stride = 1;
    int padding = 0;  ///< zeros around the input; its map's border is at least as wide
  };

  /// `weights`: outputs x inputs x kernel x kernel; `bias`: outputs. `input_stride`: numbers per pixel of the
  /// input map takes.
  Convolution(const Shape& shape, int input_stride, std::span<const float> weights,
              std::span<const float> bias);

  /// Width (or height) of what comes out.
  int output_size(int input_size) const {
    return (input_size + 2 * shape_.padding - shape_.kernel) / shape_.stride + 1;
  }
  const Shape& shape() const { return shape_; }

  /// `output` has the size that comes out; `added` its shape: it may be `output` itself.
  void apply(const FeatureMap& input, FeatureMap& output, Activation activation,
             const FeatureMap* added = nullptr) const;

 private:
  template <int kVectors>
  void apply_block(const FeatureMap& input, FeatureMap& output, Activation activation,
                   const FeatureMap* added, int first_output) const;

  Shape shape_;
  int input_stride_;
  AlignedVector weights_;  // as weights_in_blocks orders them, for kernel rows and columns
  AlignedVector bias_;
  /// Does it instead, where it can.
  std::variant<std::monostate, WinogradConvolution<Tile2>, WinogradConvolution<Tile4>> winograd_;
};

}  // namespace knuckle
