// SPDX-License-Identifier: Apache-2.0
#include "knuckle/export/encoder_decoder_graph.h"

#include <algorithm>

#include <fmt/format.h>

#include "knuckle/net/layers/batch_norm.h"

namespace knuckle {
namespace {

/// Part of an array whose first size counts outputs.
std::vector<float> rows_of(const std::vector<float>& values, std::size_t rows, const MapRange& range) {
  const std::size_t length = values.size() / rows;
  const auto first =
      values.begin() + static_cast<std::ptrdiff_t>(length * static_cast<std::size_t>(range.first));
  return {first, first + static_cast<std::ptrdiff_t>(length * static_cast<std::size_t>(range.count))};
}

class EncoderDecoderGraph {
 public:
  EncoderDecoderGraph(GraphBuilder& graph, const EncoderDecoderShape& shape, const WeightArrays& weights)
      : graph_(graph), shape_(shape), units_(encoder_decoder_units(shape)), weights_(weights) {}

  /// Follows EncoderDecoder::encode and decode.
  std::string add(const std::string& input) {
    std::string features = rectified(unit("stem", input), "stem");
    std::vector<std::string> stages;
    for (int number = 1; number <= kEncoderStages; ++number) {
      features = stage(number, features);
      stages.push_back(features);
    }
    const std::string eighth =
        joined_with(stages[1], rectified(unit("lateral2", stages[2]), "lateral2"), "joined2");
    const std::string smooth2 = rectified(unit("smooth2", eighth), "smooth2");
    const std::string quarter =
        joined_with(stages[0], rectified(unit("lateral1", smooth2), "lateral1"), "joined1");
    return rectified(unit("smooth1", quarter), "smooth1");
  }

 private:
  /// A convolution and its batch norm.
  std::string unit(const std::string& name, const std::string& input) {
    const EncoderDecoderUnit& unit = *std::ranges::find(units_, name, &EncoderDecoderUnit::name);
    const std::string weight =
        graph_.constant(name + ".convolution.weight", {unit.outputs, unit.inputs, unit.kernel, unit.kernel},
                        weights_.floats(name + ".convolution.weight"));
    const std::int64_t kernel = unit.kernel;
    const std::int64_t padding = unit.kernel / 2;
    const std::string convolution =
        graph_.node("Conv", {input, weight}, name + ".convolution",
                    {{"kernel_shape", std::vector<std::int64_t>{kernel, kernel}},
                     {"strides", std::vector<std::int64_t>{unit.stride, unit.stride}},
                     {"pads", std::vector<std::int64_t>(4, padding)}});
    return add_norm(graph_, weights_, name + ".norm", convolution);
  }

  std::string rectified(const std::string& input, const std::string& name) {
    return graph_.node("Relu", {input}, name + ".relu");
  }

  std::string stage(int number, const std::string& input) {
    const std::string down = "down" + std::to_string(number);
    std::string features = rectified(unit(down, input), down);
    for (int i = 0; i < shape_.blocks; ++i) {
      const std::string block = fmt::format("block{}_{}", number, i);
      const std::string first = rectified(unit(block + ".first", features), block + ".first");
      const std::string second = unit(block + ".second", first);
      features = rectified(graph_.node("Add", {second, features}, fmt::format("{}.sum", block)), block);
    }
    return features;
  }

  /// The finer features plus the coarser ones, each of whose pixels counts four times.
  std::string joined_with(const std::string& fine, const std::string& coarse, const std::string& name) {
    const std::string scales = graph_.constant("twice_as_large", {4}, {1.0f, 1.0f, 2.0f, 2.0f});
    const std::string larger = graph_.node("Resize", {coarse, "", scales}, name + ".larger",
                                           {{"mode", std::string("nearest")},
                                            {"coordinate_transformation_mode", std::string("asymmetric")},
                                            {"nearest_mode", std::string("floor")}});
    return graph_.node("Add", {fine, larger}, name);
  }

  GraphBuilder& graph_;
  const EncoderDecoderShape& shape_;
  std::vector<EncoderDecoderUnit> units_;
  const WeightArrays& weights_;
};

}  // namespace

std::string add_norm(GraphBuilder& graph, const WeightArrays& weights, const std::string& name,
                     const std::string& input) {
  const auto add = [&](const std::string& part, std::vector<float> values) {
    const auto count = static_cast<std::int64_t>(values.size());
    return graph.constant(name + part, {count}, std::move(values));
  };
  const auto singles = [&](const std::string& part) {
    const std::span<const float> values = weights.singles(name + part);
    return add(part, {values.begin(), values.end()});
  };
  return graph.node(
      "BatchNormalization",
      {input, add(".weight", weights.floats(name + ".weight")), add(".bias", weights.floats(name + ".bias")),
       singles(".running_mean"), singles(".running_var")},
      name, {{"epsilon", kNormEpsilon}});
}

std::string add_encoder_decoder(GraphBuilder& graph, const EncoderDecoderShape& shape,
                                const WeightArrays& weights, const std::string& input) {
  return EncoderDecoderGraph(graph, shape, weights).add(input);
}

std::string add_head(GraphBuilder& graph, const EncoderDecoderShape& shape, const WeightArrays& weights,
                     const std::string& features, const MapRange& maps, const std::string& name) {
  const auto all_maps = static_cast<std::size_t>(shape.maps);
  const std::string weight = graph.constant("head." + name + ".weight", {maps.count, shape.head, 1, 1},
                                            rows_of(weights.floats("head.weight"), all_maps, maps));
  const std::string bias = graph.constant("head." + name + ".bias", {maps.count},
                                          rows_of(weights.floats("head.bias"), all_maps, maps));
  return graph.node("Conv", {features, weight, bias}, name,
                    {{"kernel_shape", std::vector<std::int64_t>{1, 1}}});
}

}  // namespace knuckle
