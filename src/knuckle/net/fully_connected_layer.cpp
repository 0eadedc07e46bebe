// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/fully_connected_layer.h"

#include <algorithm>
#include <cstddef>

#include "knuckle/net/float8.h"

namespace knuckle {
namespace {

/// How many columns ahead of their use the memory is asked for them: 8 kB.
constexpr std::size_t kColumnsAhead = 64;

/// Asks the memory for what lies there, where the compiler knows how.
inline void prefetch(const void* place) {
#if defined(__GNUC__)
  __builtin_prefetch(place);
#endif
}

}  // namespace

FullyConnectedLayer::FullyConnectedLayer(int inputs, int outputs, Activation activation,
                                         std::span<const Half> weights, std::span<const Half> bias)
    : inputs_(inputs), outputs_(outputs), activation_(activation) {
  const int blocks = (outputs + kOutputsABlock - 1) / kOutputsABlock;
  columns_.resize(static_cast<std::size_t>(blocks) * inputs);
  bias_.resize(static_cast<std::size_t>(blocks) * kOutputsABlock);
  std::ranges::transform(bias, bias_.begin(), float_of_half);
  for (int block = 0; block < blocks; ++block) {
    Column* const columns = columns_.data() + static_cast<std::size_t>(block) * inputs;
    const int first = block * kOutputsABlock;
    const int count = std::min(kOutputsABlock, outputs - first);
    for (int i = 0; i < inputs; ++i) {
      for (int k = 0; k < count; ++k) {
        columns[i].weights[k] = weights[static_cast<std::size_t>(first + k) * inputs + i];
      }
    }
  }
}

std::vector<float> FullyConnectedLayer::apply(std::span<const float> input) const {
  constexpr int kVectors = kOutputsABlock / kLanes;
  std::vector<float> output(bias_);
  std::size_t next = 0;  // column; all are read one behind another
  for (std::size_t first = 0; first < output.size(); first += kOutputsABlock) {
    Float8 sums[kVectors];
    for (int v = 0; v < kVectors; ++v) sums[v] = load8(output.data() + first + v * kLanes);
    for (int i = 0; i < inputs_; ++i, ++next) {
      const Half* const ahead = columns_[std::min(next + kColumnsAhead, columns_.size() - 1)].weights.data();
      prefetch(ahead);
      prefetch(ahead + kOutputsABlock / 2);
      const Half* const column = columns_[next].weights.data();
      const Float8 value = all8(input[static_cast<std::size_t>(i)]);
      for (int v = 0; v < kVectors; ++v) {
        sums[v] = multiply_add(load_halves(column + v * kLanes), value, sums[v]);
      }
    }
    for (int v = 0; v < kVectors; ++v) {
      if (activation_ == Activation::relu) sums[v] = larger8(Float8{}, sums[v]);
      store8(output.data() + first + v * kLanes, sums[v]);
    }
  }
  output.resize(static_cast<std::size_t>(outputs_));
  return output;
}

}  // namespace knuckle
