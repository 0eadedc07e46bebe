// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "knuckle/net/layers/batch_norm.h"
#include "knuckle/net/layers/convolution.h"
#include "knuckle/net/layers/half.h"

namespace knuckle {

/// A fully connected layer: output = activation(scales * (weights * input) + shifts).
///
/// A wide layer is bound by reading its weights, each of which is used once: they stay in half precision in
/// memory and are read in one stream. Leaving out those of inputs that are 0 (half of them after a ReLU) was
/// slower: it breaks the stream.
class FullyConnectedLayer {
 public:
  /// `weights`: outputs x inputs; `norm`: the norm after them, or scales of 1 and a bias.
  FullyConnectedLayer(int inputs, int outputs, Activation activation, std::span<const Half> weights,
                      const FoldedNorm& norm);

  int inputs() const { return inputs_; }
  int outputs() const { return outputs_; }

  /// Returns `outputs` numbers of `inputs`.
  std::vector<float> apply(std::span<const float> input) const;

 private:
  static constexpr int kOutputsPerBlock = 64;
  /// What one input adds to a block of outputs: two lines of the cache.
  struct alignas(64) Column {
    std::array<Half, kOutputsPerBlock> weights;
  };

  int inputs_;
  int outputs_;
  Activation activation_;
  std::vector<Column> columns_;  // blocks of outputs x inputs
  std::vector<float> scales_;    // whole blocks, as shifts_
  std::vector<float> shifts_;
};

}  // namespace knuckle
