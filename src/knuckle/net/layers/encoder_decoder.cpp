// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/encoder_decoder.h"

#include <algorithm>
#include <span>
#include <string>

#include "knuckle/net/layers/batch_norm.h"
#include "knuckle/net/layers/map_operations.h"

namespace knuckle {
namespace {

constexpr int kMostPadding = 2;  // of the stem, whose kernel is 5

/// The convolution of a unit with its batch norm: what the norm multiplies goes into the weights, what it
/// adds becomes the bias.
Convolution folded_convolution(const EncoderDecoderShape& shape, const WeightArrays& weights,
                               const std::string& name) {
  const std::vector<EncoderDecoderUnit> units = encoder_decoder_units(shape);
  const EncoderDecoderUnit& unit = *std::ranges::find(units, name, &EncoderDecoderUnit::name);
  std::vector<float> kernels = weights.floats(name + ".convolution.weight");
  const FoldedNorm norm = folded_norm(weights, name + ".norm");
  const std::size_t kernel_size = kernels.size() / norm.scales.size();
  for (std::size_t i = 0; i < norm.scales.size(); ++i) {
    for (float& weight : std::span(kernels).subspan(i * kernel_size, kernel_size))
      weight = static_cast<float>(weight * norm.scales[i]);
  }
  const Convolution::Shape convolution{.inputs = unit.inputs,
                                       .outputs = unit.outputs,
                                       .kernel = unit.kernel,
                                       .stride = unit.stride,
                                       .padding = unit.kernel / 2};
  return {convolution, name == "stem" ? unit.inputs : whole_lanes(unit.inputs), kernels,
          singles_of(norm.shifts)};
}

Convolution head_convolution(const EncoderDecoderShape& shape, const WeightArrays& weights) {
  const Convolution::Shape convolution{.inputs = shape.head, .outputs = shape.maps, .kernel = 1};
  return {convolution, whole_lanes(shape.head), weights.floats("head.weight"), weights.floats("head.bias")};
}

/// A map at a part of the input's resolution, with a border for kernels of 3.
FeatureMap map_at(const EncoderDecoder::Size& size, int part, int channels) {
  return FeatureMap(
      {.height = size.height / part, .width = size.width / part, .channels = channels, .border = 1});
}

}  // namespace

EncoderDecoder::Maps::Maps(const EncoderDecoderShape& shape, const Size& size)
    : input(FeatureMap::packed({size.height, size.width, shape.inputs, kMostPadding})),
      stem(map_at(size, 2, shape.stem)),
      lateral2(map_at(size, 16, shape.eighth)),
      smooth2(map_at(size, 8, shape.eighth)),
      lateral1(map_at(size, 8, shape.quarter)),
      smooth1(map_at(size, 4, shape.head)),
      maps(map_at(size, kMapStride, shape.maps)) {
  stages = {map_at(size, 4, shape.quarter), map_at(size, 8, shape.eighth), map_at(size, 16, shape.sixteenth)};
  inner = stages;
}

EncoderDecoder::EncoderDecoder(const EncoderDecoderShape& shape, const WeightArrays& weights)
    : stem_(folded_convolution(shape, weights, "stem")),
      lateral2_(folded_convolution(shape, weights, "lateral2")),
      smooth2_(folded_convolution(shape, weights, "smooth2")),
      lateral1_(folded_convolution(shape, weights, "lateral1")),
      smooth1_(folded_convolution(shape, weights, "smooth1")),
      head_(head_convolution(shape, weights)) {
  for (int number = 1; number <= kEncoderStages; ++number) {
    const std::string name = std::to_string(number);
    Stage& stage = stages_.emplace_back(Stage{folded_convolution(shape, weights, "down" + name), {}});
    for (int i = 0; i < shape.blocks; ++i) {
      const std::string block = "block" + name + "_" + std::to_string(i);
      stage.blocks.push_back({folded_convolution(shape, weights, block + ".first"),
                              folded_convolution(shape, weights, block + ".second")});
    }
  }
}

void EncoderDecoder::apply(Maps& maps) const {
  encode(maps);
  decode(maps);
}

void EncoderDecoder::encode(Maps& maps) const {
  stem_.apply(maps.input, maps.stem, Activation::relu);
  const FeatureMap* finer = &maps.stem;
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    FeatureMap& features = maps.stages[i];
    stages_[i].down.apply(*finer, features, Activation::relu);
    for (const Block& block : stages_[i].blocks) {
      block.first.apply(features, maps.inner[i], Activation::relu);
      block.second.apply(maps.inner[i], features, Activation::relu, &features);
    }
    finer = &features;
  }
}

void EncoderDecoder::decode(Maps& maps) const {
  lateral2_.apply(maps.stages[2], maps.lateral2, Activation::relu);
  add_twice_as_large(maps.lateral2, maps.stages[1]);
  smooth2_.apply(maps.stages[1], maps.smooth2, Activation::relu);
  lateral1_.apply(maps.smooth2, maps.lateral1, Activation::relu);
  add_twice_as_large(maps.lateral1, maps.stages[0]);
  smooth1_.apply(maps.stages[0], maps.smooth1, Activation::relu);
  head_.apply(maps.smooth1, maps.maps, Activation::linear);
}

}  // namespace knuckle
