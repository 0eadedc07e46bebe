// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/convolution.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

// A few pixels by two vectors of outputs are worked on together. Their sums fill three quarters of the
// registers (16 in AVX, 32 in AVX-512), so that two multiply-adds per cycle need not wait for one another,
// and each number read serves several of them.
constexpr int kPixelsPerBlock = kLanes == 16 ? 12 : 6;
constexpr int kVectorsPerBlock = 2;
constexpr int kOutputsPerBlock = kVectorsPerBlock * kLanes;

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

/// Where a few pixels' outputs go, and what is added to them (or null).
struct Target {
  float* output;
  const float* added;
  std::ptrdiff_t output_stride;
  std::ptrdiff_t added_stride;
  Activation activation;
};

template <int kPixels, int kVectors>
void convolve_pixels(const Window& window, const float* weights, const float* bias, const Target& target) {
  Sums<kPixels, kVectors> sums;
  for (int p = 0; p < kPixels; ++p) {
    for (int v = 0; v < kVectors; ++v) sums[p][v] = load_lanes(bias + v * kLanes);
  }
  add_products<kPixels, kVectors>(window, weights, sums);
  for (int p = 0; p < kPixels; ++p) {
    for (int v = 0; v < kVectors; ++v) {
      FloatLanes value = sums[p][v];
      if (target.added != nullptr) value += load_lanes(target.added + p * target.added_stride + v * kLanes);
      if (target.activation == Activation::relu) value = larger_lanes(FloatLanes{}, value);
      store_lanes(target.output + p * target.output_stride + v * kLanes, value);
    }
  }
}

using ConvolvePixels = void (*)(const Window&, const float*, const float*, const Target&);

template <int kVectors, int... kFewer>
constexpr std::array<ConvolvePixels, sizeof...(kFewer)> by_pixels(std::integer_sequence<int, kFewer...>) {
  return {convolve_pixels<kFewer + 1, kVectors>...};
}

/// By the number of pixels, from one on.
template <int kVectors>
constexpr auto kConvolvePixels = by_pixels<kVectors>(std::make_integer_sequence<int, kPixelsPerBlock>{});

}  // namespace

Convolution::Convolution(const Shape& shape, int input_stride, std::span<const float> weights,
                         std::span<const float> bias)
    : shape_(shape), input_stride_(input_stride), bias_(bias.begin(), bias.end()) {
  const int outputs = whole_lanes(shape.outputs);
  const int window = shape.kernel * shape.kernel;
  bias_.resize(static_cast<std::size_t>(outputs));
  weights_.resize(static_cast<std::size_t>(outputs) * window * input_stride);
  for (int output = 0; output < shape.outputs; ++output) {
    const int first = output / kOutputsPerBlock * kOutputsPerBlock;
    const int width = std::min(kOutputsPerBlock, outputs - first);
    float* const block = weights_.data() + static_cast<std::size_t>(first) * window * input_stride;
    for (int input = 0; input < shape.inputs; ++input) {
      for (int k = 0; k < window; ++k) {
        const std::size_t from = (static_cast<std::size_t>(output) * shape.inputs + input) * window + k;
        const std::size_t place = static_cast<std::size_t>(k) * input_stride + input;
        block[place * width + (output - first)] = weights[from];
      }
    }
  }
}

void Convolution::apply(const FeatureMap& input, FeatureMap& output, Activation activation,
                        const FeatureMap* added) const {
  const int outputs = whole_lanes(shape_.outputs);
  int first = 0;
  for (; first + kOutputsPerBlock <= outputs; first += kOutputsPerBlock) {
    apply_block<kVectorsPerBlock>(input, output, activation, added, first);
  }
  if (first < outputs) apply_block<1>(input, output, activation, added, first);
}

template <int kVectors>
void Convolution::apply_block(const FeatureMap& input, FeatureMap& output, Activation activation,
                              const FeatureMap* added, int first_output) const {
  const float* const weights = weights_.data() + static_cast<std::size_t>(first_output) * shape_.kernel *
                                                     shape_.kernel * input_stride_;
  const float* const bias = bias_.data() + first_output;
  const auto input_stride = static_cast<std::ptrdiff_t>(shape_.stride) * input_stride_;
  for (int row = 0; row < output.height(); ++row) {
    for (int column = 0; column < output.width(); column += kPixelsPerBlock) {
      const int pixels = std::min(kPixelsPerBlock, output.width() - column);
      const float* const corner =
          input.pixel(row * shape_.stride - shape_.padding, column * shape_.stride - shape_.padding);
      const Window window{corner, input_stride, input.row_stride(), shape_.kernel,
                          shape_.kernel * input_stride_};
      const Target target{output.pixel(row, column) + first_output,
                          added == nullptr ? nullptr : added->pixel(row, column) + first_output,
                          output.pixel_stride(), added == nullptr ? 0 : added->pixel_stride(), activation};
      kConvolvePixels<kVectors>[pixels - 1](window, weights, bias, target);
    }
  }
}

}  // namespace knuckle
