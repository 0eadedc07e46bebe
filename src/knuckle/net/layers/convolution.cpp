// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/convolution.h"

#include <algorithm>
#include <cstddef>

#include "knuckle/net/layers/lane_products.h"

namespace knuckle {
namespace {

/// Where a few pixels' outputs go, and what is added to them (or null).
struct Target {
  float* output;
  const float* added;
  std::ptrdiff_t output_stride;
  std::ptrdiff_t added_stride;
  Activation activation;
};

/// The outputs of a few pixels.
struct ConvolvedPixels {
  template <int kPixels, int kVectors>
  static void run(const Window& window, const float* weights, const float* bias, const Target& target) {
    Sums<kPixels, kVectors> sums;
    for (int p = 0; p < kPixels; ++p) {
      for (int v = 0; v < kVectors; ++v) sums[p][v] = load_lanes(bias + v * kLanes);
    }
    add_products<kPixels, kVectors>(window, weights, sums);
    for (int p = 0; p < kPixels; ++p) {
      for (int v = 0; v < kVectors; ++v) {
        const float* const added =
            target.added == nullptr ? nullptr : target.added + p * target.added_stride + v * kLanes;
        store_lanes(target.output + p * target.output_stride + v * kLanes,
                    activated(sums[p][v], added, target.activation));
      }
    }
  }
};

template <int kVectors>
constexpr auto kConvolvedPixels = loops_by_pixels<ConvolvedPixels, kVectors>();

/// Below so many inputs the transforms take more time than they save.
constexpr int kLeastInputsOfWinograd = 16;
/// Inputs times outputs, of which each has 36 numbers. More would not stay in the second cache (2 MB) until
/// they are needed again, and maps of so many channels have but a few tiles to use them for.
constexpr int kMostKernelsOfTile4 = 12000;

bool suits_winograd(const Convolution::Shape& shape, int input_stride) {
  return shape.kernel == 3 && shape.stride == 1 && shape.padding == 1 &&
         shape.inputs >= kLeastInputsOfWinograd && input_stride == whole_lanes(shape.inputs);
}

}  // namespace

Convolution::Convolution(const Shape& shape, int input_stride, std::span<const float> weights,
                         std::span<const float> bias)
    : shape_(shape), input_stride_(input_stride), bias_(bias.begin(), bias.end()) {
  bias_.resize(static_cast<std::size_t>(whole_lanes(shape.outputs)));
  if (!suits_winograd(shape, input_stride)) {
    const int window = shape.kernel * shape.kernel;
    weights_ = weights_in_blocks(weights, shape.outputs, shape.inputs, window, input_stride);
  } else if (shape.inputs * shape.outputs <= kMostKernelsOfTile4) {
    winograd_.emplace<WinogradConvolution<Tile4>>(shape.inputs, shape.outputs, input_stride, weights, bias);
  } else {
    winograd_.emplace<WinogradConvolution<Tile2>>(shape.inputs, shape.outputs, input_stride, weights, bias);
  }
}

void Convolution::apply(const FeatureMap& input, FeatureMap& output, Activation activation,
                        const FeatureMap* added) const {
  if (const auto* const tile2 = std::get_if<WinogradConvolution<Tile2>>(&winograd_))
    return tile2->apply(input, output, activation, added);
  if (const auto* const tile4 = std::get_if<WinogradConvolution<Tile4>>(&winograd_))
    return tile4->apply(input, output, activation, added);
  const int outputs = whole_lanes(shape_.outputs);
  int first = 0;
  for (; first + kOutputsTogether <= outputs; first += kOutputsTogether) {
    apply_block<kVectorsTogether>(input, output, activation, added, first);
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
    for (int column = 0; column < output.width(); column += kPixelsTogether) {
      const int pixels = std::min(kPixelsTogether, output.width() - column);
      const float* const corner =
          input.pixel(row * shape_.stride - shape_.padding, column * shape_.stride - shape_.padding);
      const Window window{corner, input_stride, input.row_stride(), shape_.kernel,
                          shape_.kernel * input_stride_};
      const Target target{output.pixel(row, column) + first_output,
                          added == nullptr ? nullptr : added->pixel(row, column) + first_output,
                          output.pixel_stride(), added == nullptr ? 0 : added->pixel_stride(), activation};
      kConvolvedPixels<kVectors>[static_cast<std::size_t>(pixels) - 1](window, weights, bias, target);
    }
  }
}

}  // namespace knuckle
