// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/dense_inference.h"

#include <algorithm>

#include "knuckle/net/batch_norm.h"
#include "knuckle/net/map_operations.h"
#include "knuckle/net/vote_aggregation.h"

namespace knuckle {
namespace {

constexpr int kMostPadding = 2;  // of the stem, whose kernel is 5

/// The convolution of a unit with its batch norm: what the norm multiplies goes into the weights, what it
/// adds becomes the bias.
Convolution folded_convolution(const NetworkWeights& weights, const std::string& name) {
  const std::vector<DenseUnit> units = dense_units(weights.options().dense);
  const DenseUnit& unit = *std::ranges::find(units, name, &DenseUnit::name);
  std::vector<float> kernels = weights.floats(name + ".convolution.weight");
  const FoldedNorm norm = folded_norm(weights, name + ".norm");
  const std::size_t kernel_size = kernels.size() / norm.scales.size();
  for (std::size_t i = 0; i < norm.scales.size(); ++i) {
    for (float& weight : std::span(kernels).subspan(i * kernel_size, kernel_size)) weight *= norm.scales[i];
  }
  const Convolution::Shape shape{.inputs = unit.inputs,
                                 .outputs = unit.outputs,
                                 .kernel = unit.kernel,
                                 .stride = unit.stride,
                                 .padding = unit.kernel / 2};
  return {shape, name == "stem" ? 1 : whole_lanes(unit.inputs), kernels, norm.shifts};
}

Convolution head_convolution(const NetworkWeights& weights) {
  const Convolution::Shape shape{.inputs = weights.options().dense.head_channels,
                                 .outputs = kMapsPerJoint * weights.options().joint_count(),
                                 .kernel = 1};
  return {shape, whole_lanes(shape.inputs), weights.floats("head.weight"), weights.floats("head.bias")};
}

/// A map at a part of the patch's resolution, with a border for kernels of 3.
FeatureMap map_at(const NetworkOptions& options, int part, int channels) {
  const int size = options.patch.size_px / part;
  return FeatureMap({.height = size, .width = size, .channels = channels, .border = 1});
}

}  // namespace

DenseInference::Maps::Maps(const NetworkOptions& options)
    : patch(FeatureMap::of_image(options.patch.size_px, kMostPadding)),
      stem(map_at(options, 2, options.dense.stem_channels)),
      lateral2(map_at(options, 16, options.dense.eighth_channels)),
      smooth2(map_at(options, 8, options.dense.eighth_channels)),
      lateral1(map_at(options, 8, options.dense.quarter_channels)),
      smooth1(map_at(options, 4, options.dense.head_channels)),
      votes(map_at(options, kDenseStride, kMapsPerJoint * options.joint_count())) {
  stages = {map_at(options, 4, options.dense.quarter_channels),
            map_at(options, 8, options.dense.eighth_channels),
            map_at(options, 16, options.dense.sixteenth_channels)};
  inner = stages;
}

DenseInference::DenseInference(const NetworkWeights& weights)
    : options_(weights.options()),
      stem_(folded_convolution(weights, "stem")),
      lateral2_(folded_convolution(weights, "lateral2")),
      smooth2_(folded_convolution(weights, "smooth2")),
      lateral1_(folded_convolution(weights, "lateral1")),
      smooth1_(folded_convolution(weights, "smooth1")),
      head_(head_convolution(weights)),
      pool_([options = options_] { return Maps(options); }) {
  for (int number = 1; number <= kDenseStages; ++number) {
    const std::string name = std::to_string(number);
    Stage& stage = stages_.emplace_back(Stage{folded_convolution(weights, "down" + name), {}});
    for (int i = 0; i < options_.dense.blocks; ++i) {
      const std::string block = "block" + name + "_" + std::to_string(i);
      stage.blocks.push_back(
          {folded_convolution(weights, block + ".first"), folded_convolution(weights, block + ".second")});
    }
  }
}

void DenseInference::encode(Maps& maps) const {
  stem_.apply(maps.patch, maps.stem, Activation::relu);
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

void DenseInference::decode(Maps& maps) const {
  lateral2_.apply(maps.stages[2], maps.lateral2, Activation::relu);
  add_twice_as_large(maps.lateral2, maps.stages[1]);
  smooth2_.apply(maps.stages[1], maps.smooth2, Activation::relu);
  lateral1_.apply(maps.smooth2, maps.lateral1, Activation::relu);
  add_twice_as_large(maps.lateral1, maps.stages[0]);
  smooth1_.apply(maps.stages[0], maps.smooth1, Activation::relu);
  head_.apply(maps.smooth1, maps.votes, Activation::linear);
}

NetworkPrediction DenseInference::predict(const Image<float>& patch) const {
  return pool_.with_workspace([&](Maps& maps) {
    copy_image(patch, maps.patch);
    encode(maps);
    decode(maps);
    return aggregate_votes(maps.votes, patch, options_.joint_count(), options_.dense.kernel);
  });
}

}  // namespace knuckle
