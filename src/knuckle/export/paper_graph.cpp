// SPDX-License-Identifier: Apache-2.0
#include "knuckle/export/paper_graph.h"

#include "knuckle/export/encoder_decoder_graph.h"
#include "knuckle/export/graph_builder.h"
#include "knuckle/net/paper_architecture.h"

namespace knuckle {
namespace {

using Sizes = std::vector<std::int64_t>;

class PaperGraph {
 public:
  PaperGraph(OnnxModel& model, const NetworkWeights& weights)
      : graph_(model), weights_(weights), options_(weights.options()) {}

  void add() {
    const std::int64_t size = options_.patch.size_px;
    graph_.input("patch", {1, 1, size, size});
    std::string values = banks();
    int inputs = bank_feature_count(options_.patch.size_px, options_.paper.second_maps);
    const std::vector<ConnectedLayer> layers = connected_layers(options_);
    for (std::size_t i = 0; i + 1 < layers.size(); ++i) {
      values = connected(values, "layers.layer" + std::to_string(i), inputs, layers[i]);
      inputs = layers[i].units;
    }
    add_outputs(values, "layers.layer" + std::to_string(layers.size() - 1), inputs);
  }

 private:
  std::string banks() {
    std::vector<std::string> features;
    std::string image = "patch";
    int number = 0;
    for (int b = 0; b < kBanks; ++b) {
      if (b > 0) {
        image = graph_.node("AveragePool", {image}, "halved" + std::to_string(b),
                            {{"kernel_shape", Sizes{2, 2}}, {"strides", Sizes{2, 2}}});
      }
      std::string maps = image;
      int channels = 1;
      for (const BankLayer& layer : kBankLayers[b]) {
        const int outputs =
            channels == 1 && maps == image ? options_.paper.first_maps : options_.paper.second_maps;
        maps = convolved(maps, "banks.convolution" + std::to_string(number++), channels, outputs, layer);
        channels = outputs;
      }
      features.push_back(
          graph_.node("Flatten", {maps}, "bank" + std::to_string(b), {{"axis", std::int64_t{1}}}));
    }
    return graph_.node("Concat", features, "banks", {{"axis", std::int64_t{1}}});
  }

  std::string convolved(const std::string& input, const std::string& name, int inputs, int outputs,
                        const BankLayer& layer) {
    const std::int64_t kernel = layer.kernel;
    const std::int64_t pool = layer.pool;
    const std::string weight = graph_.constant(name + ".weight", {outputs, inputs, kernel, kernel},
                                               weights_.floats(name + ".weight"));
    const std::string bias = graph_.constant(name + ".bias", {outputs}, weights_.floats(name + ".bias"));
    const std::string sums =
        graph_.node("Conv", {input, weight, bias}, name, {{"kernel_shape", Sizes{kernel, kernel}}});
    std::string rectified = graph_.node("Relu", {sums}, name + ".relu");
    if (pool == 1) return rectified;
    return graph_.node("MaxPool", {rectified}, name + ".pooled",
                       {{"kernel_shape", Sizes{pool, pool}}, {"strides", Sizes{pool, pool}}});
  }

  std::string connected(const std::string& input, const std::string& name, int inputs,
                        const ConnectedLayer& layer) {
    if (!layer.has_norm()) return linear(input, name, inputs, {0, layer.units}, name);
    const std::string weight = graph_.constant(name + ".linear.weight", {layer.units, inputs},
                                               weights_.floats(name + ".linear.weight"));
    const std::string sums = graph_.node("Gemm", {input, weight}, name, {{"transB", std::int64_t{1}}});
    // As an image of one pixel: a batch norm of plain numbers is no matter of course to engines.
    const std::string pixel = graph_.reshape(sums, name + ".pixel", {1, layer.units, 1, 1});
    const std::string norm = add_norm(graph_, weights_, name + ".norm", pixel);
    const std::string numbers = graph_.reshape(norm, name + ".numbers", {1, layer.units});
    return graph_.node("Relu", {numbers}, name + ".relu");
  }

  /// Some of the outputs of a layer without a norm.
  std::string linear(const std::string& input, const std::string& layer, int inputs, const MapRange& outputs,
                     const std::string& name) {
    const auto part = [&](const std::string& array, int length) {
      const std::vector<float> values = weights_.floats(layer + array);
      const auto first = values.begin() + static_cast<std::ptrdiff_t>(outputs.first) * length;
      return std::vector<float>(first, first + static_cast<std::ptrdiff_t>(outputs.count) * length);
    };
    const std::string weight =
        graph_.constant(name + ".linear.weight", {outputs.count, inputs}, part(".linear.weight", inputs));
    const std::string bias = graph_.constant(name + ".linear.bias", {outputs.count}, part(".linear.bias", 1));
    return graph_.node("Gemm", {input, weight, bias}, name, {{"transB", std::int64_t{1}}});
  }

  void add_outputs(const std::string& values, const std::string& layer, int inputs) {
    const int joints = options_.joint_count();
    if (!options_.architecture.starts_with("heatmap")) {
      const std::string numbers = linear(values, layer, inputs, {0, 3 * joints}, layer);
      graph_.reshape(numbers, "landmarks", {1, joints, 3});
      graph_.output("landmarks", {1, joints, 3});
      return;
    }
    const int cells = options_.paper.map_cells;
    const int bins = depth_bins_per_joint(options_);
    const int maps = joints * cells * cells;
    graph_.reshape(linear(values, layer, inputs, {0, maps}, layer + ".maps"), "heat_maps",
                   {1, joints, cells, cells});
    graph_.output("heat_maps", {1, joints, cells, cells});
    if (bins == 0) return;
    graph_.reshape(linear(values, layer, inputs, {maps, joints * bins}, layer + ".bins"), "depth_bins",
                   {1, joints, bins});
    graph_.output("depth_bins", {1, joints, bins});
  }

  GraphBuilder graph_;
  const NetworkWeights& weights_;
  const NetworkOptions& options_;
};

}  // namespace

void add_paper_graph(OnnxModel& model, const NetworkWeights& weights) {
  PaperGraph(model, weights).add();
}

}  // namespace knuckle
