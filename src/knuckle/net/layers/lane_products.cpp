// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/lane_products.h"

#include <algorithm>

namespace knuckle {

AlignedVector weights_in_blocks(std::span<const float> weights, int outputs, int inputs, int window,
                                int input_stride) {
  const int padded_outputs = whole_lanes(outputs);
  AlignedVector blocks(static_cast<std::size_t>(padded_outputs) * window * input_stride);
  for (int output = 0; output < outputs; ++output) {
    const int first = output / kOutputsTogether * kOutputsTogether;
    const int width = std::min(kOutputsTogether, padded_outputs - first);
    float* const block = blocks.data() + static_cast<std::size_t>(first) * window * input_stride;
    for (int input = 0; input < inputs; ++input) {
      for (int k = 0; k < window; ++k) {
        const std::size_t from = (static_cast<std::size_t>(output) * inputs + input) * window + k;
        const std::size_t place = static_cast<std::size_t>(k) * input_stride + input;
        block[place * width + (output - first)] = weights[from];
      }
    }
  }
  return blocks;
}

}  // namespace knuckle
