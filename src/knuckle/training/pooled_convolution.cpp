// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/pooled_convolution.h"

#include <algorithm>
#include <span>

#include <torch/autograd.h>
#include <torch/nn/functional/conv.h>
#include <torch/nn/functional/pooling.h>
#include <torch/utils.h>

#include "knuckle/net/layers/convolution.h"

namespace knuckle {
namespace {

/// Sizes of maps, kernel and pools.
struct Sizes {
  Sizes(const torch::Tensor& maps, const torch::Tensor& weight, const PooledConvolutionShape& shape)
      : samples(maps.size(0)),
        inputs(static_cast<int>(maps.size(1))),
        outputs(static_cast<int>(weight.size(0))),
        height(static_cast<int>(maps.size(2))),
        width(static_cast<int>(maps.size(3))),
        kernel(shape.kernel),
        pool(shape.pool),
        pooled_height((height - kernel + 1) / pool),
        pooled_width((width - kernel + 1) / pool) {}

  int64_t map_numbers() const { return int64_t{height} * width * inputs; }
  int64_t pooled_numbers() const { return int64_t{pooled_height} * pooled_width * outputs; }
  /// Of the numbers in a row of the kernel, inputs side by side.
  int64_t kernel_row() const { return int64_t{kernel} * inputs; }
  int64_t map_row() const { return int64_t{width} * inputs; }

  int64_t samples;
  int inputs, outputs, height, width, kernel, pool, pooled_height, pooled_width;
};

/// N x C x H x W, all channels of a pixel side by side.
torch::Tensor by_pixel(const torch::Tensor& maps) {
  return maps.contiguous(torch::MemoryFormat::ChannelsLast);
}

torch::Tensor empty_by_pixel(torch::IntArrayRef sizes, torch::ScalarType type) {
  return torch::empty(sizes, torch::TensorOptions(type).memory_format(torch::MemoryFormat::ChannelsLast));
}

std::span<const float> numbers_of(const torch::Tensor& tensor) {
  return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
}

void copy_in(const float* from, FeatureMap& map) {
  for (int row = 0; row < map.height(); ++row) {
    for (int column = 0; column < map.width(); ++column, from += map.channels()) {
      std::copy_n(from, map.channels(), map.pixel(row, column));
    }
  }
}

/// The largest of each pool, not below 0, and which of the pool's pixels it is: the first of equals.
void pool_rectified(const FeatureMap& convolved, const Sizes& sizes, float* pooled, std::uint8_t* places) {
  for (int row = 0; row < sizes.pooled_height; ++row) {
    for (int column = 0; column < sizes.pooled_width; ++column) {
      std::copy_n(convolved.pixel(row * sizes.pool, column * sizes.pool), sizes.outputs, pooled);
      std::fill_n(places, sizes.outputs, std::uint8_t{0});
      for (int k = 1; k < sizes.pool * sizes.pool; ++k) {
        const float* const values =
            convolved.pixel(row * sizes.pool + k / sizes.pool, column * sizes.pool + k % sizes.pool);
        for (int o = 0; o < sizes.outputs; ++o) {
          places[o] = values[o] > pooled[o] ? static_cast<std::uint8_t>(k) : places[o];
          pooled[o] = std::max(values[o], pooled[o]);
        }
      }
      for (int o = 0; o < sizes.outputs; ++o) pooled[o] = std::max(pooled[o], 0.0f);
      pooled += sizes.outputs;
      places += sizes.outputs;
    }
  }
}

void add_multiple(const float* __restrict from, float factor, int64_t count, float* __restrict to) {
  for (int64_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

/// Pointers to one sample's numbers on the way back; `map_gradient` is null where nobody asks for it.
struct SampleGradients {
  const float* map;
  const float* pooled;
  const float* pooled_gradient;
  const std::uint8_t* places;
  float* map_gradient;
};

/// Of one output: kernel x kernel x inputs.
struct OutputGradients {
  const float* weight;
  float* weight_gradient;
  float* bias_gradient;
};

void add_gradients(const Sizes& sizes, const SampleGradients& sample, int output,
                   const OutputGradients& gradients) {
  int64_t place = output;
  for (int row = 0; row < sizes.pooled_height; ++row) {
    for (int column = 0; column < sizes.pooled_width; ++column, place += sizes.outputs) {
      const float gradient = sample.pooled_gradient[place];
      if (!(sample.pooled[place] > 0.0f) || gradient == 0.0f) continue;
      *gradients.bias_gradient += gradient;
      const int y = row * sizes.pool + sample.places[place] / sizes.pool;
      const int x = column * sizes.pool + sample.places[place] % sizes.pool;
      const int64_t corner = y * sizes.map_row() + int64_t{x} * sizes.inputs;
      for (int k = 0; k < sizes.kernel; ++k) {
        const int64_t from = corner + k * sizes.map_row();
        const int64_t kernel_row = k * sizes.kernel_row();
        add_multiple(sample.map + from, gradient, sizes.kernel_row(), gradients.weight_gradient + kernel_row);
        if (sample.map_gradient == nullptr) continue;
        add_multiple(gradients.weight + kernel_row, gradient, sizes.kernel_row(), sample.map_gradient + from);
      }
    }
  }
}

class PooledConvolution final : public torch::autograd::Function<PooledConvolution> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& any_maps,
                               const torch::Tensor& weight, const torch::Tensor& bias, int64_t pool) {
    const torch::Tensor maps = by_pixel(any_maps);
    const PooledConvolutionShape shape{static_cast<int>(weight.size(2)), static_cast<int>(pool)};
    const Sizes sizes(maps, weight, shape);
    const std::vector<int64_t> pooled_sizes{sizes.samples, sizes.outputs, sizes.pooled_height,
                                            sizes.pooled_width};
    torch::Tensor pooled = empty_by_pixel(pooled_sizes, torch::kFloat);
    torch::Tensor places = empty_by_pixel(pooled_sizes, torch::kByte);
    FeatureMap map({.height = sizes.height, .width = sizes.width, .channels = sizes.inputs});
    if (sizes.inputs == 1 && sizes.height == sizes.width) map = FeatureMap::of_image(sizes.height, 0);
    FeatureMap convolved({.height = sizes.height - sizes.kernel + 1,
                          .width = sizes.width - sizes.kernel + 1,
                          .channels = sizes.outputs});
    const torch::Tensor weights = weight.contiguous();
    const Convolution convolution({.inputs = sizes.inputs, .outputs = sizes.outputs, .kernel = sizes.kernel},
                                  map.pixel_stride(), numbers_of(weights), numbers_of(bias));
    for (int64_t n = 0; n < sizes.samples; ++n) {
      copy_in(maps.data_ptr<float>() + n * sizes.map_numbers(), map);
      convolution.apply(map, convolved, Activation::linear);
      pool_rectified(convolved, sizes, pooled.data_ptr<float>() + n * sizes.pooled_numbers(),
                     places.data_ptr<std::uint8_t>() + n * sizes.pooled_numbers());
    }
    context->save_for_backward({maps, weight, pooled, places});
    context->saved_data["pool"] = pool;
    return pooled;
  }

  static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                               const torch::autograd::tensor_list& output_gradients) {
    const torch::autograd::tensor_list saved = context->get_saved_variables();
    const torch::Tensor& maps = saved[0];
    const torch::Tensor& pooled = saved[2];
    const torch::Tensor& places = saved[3];
    const Sizes sizes(
        maps, saved[1],
        {static_cast<int>(saved[1].size(2)), static_cast<int>(context->saved_data["pool"].toInt())});
    const torch::Tensor weight = by_pixel(saved[1]);
    const torch::Tensor pooled_gradient = by_pixel(output_gradients[0]);
    torch::Tensor map_gradient;
    if (context->needs_input_grad(0)) map_gradient = torch::zeros_like(maps);
    torch::Tensor weight_gradient = torch::zeros_like(weight);
    torch::Tensor bias_gradient = torch::zeros({sizes.outputs});
    const int64_t kernel_numbers = sizes.kernel * sizes.kernel_row();
    for (int64_t n = 0; n < sizes.samples; ++n) {
      const SampleGradients sample{
          maps.data_ptr<float>() + n * sizes.map_numbers(),
          pooled.data_ptr<float>() + n * sizes.pooled_numbers(),
          pooled_gradient.data_ptr<float>() + n * sizes.pooled_numbers(),
          places.data_ptr<std::uint8_t>() + n * sizes.pooled_numbers(),
          map_gradient.defined() ? map_gradient.data_ptr<float>() + n * sizes.map_numbers() : nullptr};
      for (int output = 0; output < sizes.outputs; ++output) {
        add_gradients(sizes, sample, output,
                      {weight.data_ptr<float>() + output * kernel_numbers,
                       weight_gradient.data_ptr<float>() + output * kernel_numbers,
                       bias_gradient.data_ptr<float>() + output});
      }
    }
    return {map_gradient, weight_gradient, bias_gradient, torch::Tensor()};
  }
};

/// Where the way by pixels holds: `places` counts a pool's pixels in 8 bits.
bool is_for_this_processor(const torch::Tensor& maps, const PooledConvolutionShape& shape) {
  constexpr int kMostPixelsPerPool = 256;
  return maps.device().is_cpu() && maps.scalar_type() == torch::kFloat &&
         shape.pool * shape.pool <= kMostPixelsPerPool;
}

}  // namespace

torch::Tensor pooled_convolution(const torch::Tensor& maps, const torch::Tensor& weight,
                                 const torch::Tensor& bias, const PooledConvolutionShape& shape) {
  if (is_for_this_processor(maps, shape)) return PooledConvolution::apply(maps, weight, bias, shape.pool);
  // The largest of the rectified values is the rectified largest.
  return torch::relu(torch::max_pool2d(torch::conv2d(maps, weight, bias), {shape.pool, shape.pool}));
}

}  // namespace knuckle
