// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/fully_connected_layer.h"

#include <algorithm>
#include <cstddef>

#include "knuckle/net/layers/float_lanes.h"

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
                                         std::span<const Half> weights, const FoldedNorm& norm)
    : inputs_(inputs),
      outputs_(outputs),
      activation_(activation),
      scales_(singles_of(norm.scales)),
      shifts_(singles_of(norm.shifts)) {
  const int blocks = (outputs + kOutputsPerBlock - 1) / kOutputsPerBlock;
  columns_.resize(static_cast<std::size_t>(blocks) * inputs);
  scales_.resize(static_cast<std::size_t>(blocks) * kOutputsPerBlock);
  shifts_.resize(scales_.size());
  for (int block = 0; block < blocks; ++block) {
    Column* const columns = columns_.data() + static_cast<std::size_t>(block) * inputs;
    const int first = block * kOutputsPerBlock;
    const int count = std::min(kOutputsPerBlock, outputs - first);
    for (int i = 0; i < inputs; ++i) {
      for (int k = 0; k < count; ++k) {
        columns[i].weights[k] = weights[static_cast<std::size_t>(first + k) * inputs + i];
      }
    }
  }
}

std::vector<float> FullyConnectedLayer::apply(std::span<const float> input) const {
  constexpr int kVectors = kOutputsPerBlock / kLanes;
  std::vector<float> output(shifts_.size());
  std::size_t next = 0;  // column; all are read one after another
  for (std::size_t first = 0; first < output.size(); first += kOutputsPerBlock) {
    FloatLanes sums[kVectors] = {};
    for (int i = 0; i < inputs_; ++i, ++next) {
      const Half* const ahead = columns_[std::min(next + kColumnsAhead, columns_.size() - 1)].weights.data();
      prefetch(ahead);
      prefetch(ahead + kOutputsPerBlock / 2);
      const Half* const column = columns_[next].weights.data();
      const FloatLanes value = all_lanes(input[static_cast<std::size_t>(i)]);
      for (int v = 0; v < kVectors; ++v) {
        sums[v] = multiply_add(load_halves(column + v * kLanes), value, sums[v]);
      }
    }
    for (int v = 0; v < kVectors; ++v) {
      const std::size_t place = first + static_cast<std::size_t>(v) * kLanes;
      sums[v] = multiply_add(load_lanes(scales_.data() + place), sums[v], load_lanes(shifts_.data() + place));
      if (activation_ == Activation::relu) sums[v] = larger_lanes(FloatLanes{}, sums[v]);
      store_lanes(output.data() + place, sums[v]);
    }
  }
  output.resize(static_cast<std::size_t>(outputs_));
  return output;
}

}  // namespace knuckle
