// SPDX-License-Identifier: Apache-2.0
// Private to the module: the inner loop of convolutions.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>

#include "knuckle/net/layers/aligned_vector.h"
#include "knuckle/net/layers/float_lanes.h"

namespace knuckle {

/// Pixels that are worked on together, by two vectors of outputs. Their sums fill three quarters of the
/// registers (16 in AVX, 32 in AVX-512), so that two multiply-adds per cycle need not wait for one another,
/// and each number read serves several of them.
inline constexpr int kPixelsTogether = kLanes == 16 ? 12 : 6;
inline constexpr int kVectorsTogether = 2;                          ///< of outputs
inline constexpr int kOutputsTogether = kVectorsTogether * kLanes;  ///< in these vectors

/// What the sums of a few pixels run over. In a row of the kernel, columns and inputs lie one after another.
struct Window {
  const float* input;           // of the first pixel
  std::ptrdiff_t pixel_stride;  // from one output's input to the next one's
  std::ptrdiff_t row_stride;
  int rows;
  int numbers_per_row;
};

template <int kPixels, int kVectors>
using Sums = FloatLanes[kPixels][kVectors];

/// Adds each pixel's numbers times the weights: rows x numbers x outputs.
template <int kPixels, int kVectors>
inline void add_products(const Window& window, const float* weights, Sums<kPixels, kVectors>& sums) {
  const float* row = window.input;
  for (int y = 0; y < window.rows; ++y, row += window.row_stride) {
    for (int i = 0; i < window.numbers_per_row; ++i, weights += kVectors * kLanes) {
      FloatLanes weight[kVectors];
      for (int v = 0; v < kVectors; ++v) weight[v] = load_lanes(weights + v * kLanes);
      for (int p = 0; p < kPixels; ++p) {
        const FloatLanes value = all_lanes(row[p * window.pixel_stride + i]);
        for (int v = 0; v < kVectors; ++v) sums[p][v] = multiply_add(value, weight[v], sums[p][v]);
      }
    }
  }
}

/// `Loop::run<kPixels, kVectors>` for each number of pixels, from one on.
template <class Loop, int kVectors>
constexpr auto loops_by_pixels() {
  return []<int... kFewer>(std::integer_sequence<int, kFewer...>) {
    return std::array{&Loop::template run<kFewer + 1, kVectors>...};
  }
  (std::make_integer_sequence<int, kPixelsTogether>{});
}

/// Numbers of outputs x inputs x window, as in a file, in the order in which add_products reads them: outputs
/// in blocks of two vectors (the last one maybe one); each: window, inputs (`input_stride` of them), outputs
/// of the block.
AlignedVector weights_in_blocks(std::span<const float> weights, int outputs, int inputs, int window,
                                int input_stride);

}  // namespace knuckle
