// SPDX-License-Identifier: Apache-2.0
#include "knuckle/export/export_network.h"

#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/text.h"
#include "knuckle/export/dense_graph.h"
#include "knuckle/export/encoder_decoder_graph.h"
#include "knuckle/export/paper_graph.h"
#include "knuckle/net/exported_network.h"
#include "knuckle/net/network_file.h"
#include "knuckle/net/onnx/onnx_check.h"
#include "knuckle/net/onnx/onnx_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

OnnxModel empty_model(const std::string& graph_name) {
  OnnxModel model;
  model.producer = "Knuckle";
  model.graph_name = graph_name;
  return model;
}

std::string landmark_names(const NetworkOptions& options) {
  std::vector<std::string> names;
  for (const Landmark landmark : options.landmarks().landmarks) {
    names.emplace_back(name_of(landmark));
  }
  return joined(names);
}

std::int64_t number_count(const OnnxModel& model) {
  std::int64_t count = 0;
  for (const auto& [name, tensor] : model.constants) count += static_cast<std::int64_t>(tensor.reals.size());
  return count;
}

struct NamedModel {
  std::string network;
  OnnxModel model;
};

NamedModel model_of(ModelFile file) {
  if (file.format() == kNetworkFormat.name) {
    const NetworkWeights weights = read_network_weights(std::move(file));
    return {weights.options().architecture, onnx_of(weights)};
  }
  if (file.format() == kDetectorFormat.name)
    return {"detector", onnx_of(read_detector_weights(std::move(file)))};
  fail("{}: a file of the format \"{}\", expected a network, \"{}\" or \"{}\"", file.origin(), file.format(),
       kNetworkFormat.name, kDetectorFormat.name);
}

}  // namespace

OnnxModel onnx_of(const NetworkWeights& weights) {
  const NetworkOptions& options = weights.options();
  OnnxModel model = empty_model(options.architecture);
  if (options.architecture == "dense") {
    add_dense_graph(model, weights);
  } else {
    add_paper_graph(model, weights);
  }
  set_exported_options(model, options);
  model.metadata["knuckle.landmarks"] = landmark_names(options);
  return model;
}

OnnxModel onnx_of(const DetectorWeights& weights) {
  const DetectorOptions& options = weights.options();
  OnnxModel model = empty_model("detector");
  GraphBuilder graph(model);
  graph.input("picture", {1, options.inputs(), options.height, options.width});
  const EncoderDecoderShape shape = options.shape();
  const std::string features = add_encoder_decoder(graph, shape, weights, "picture");
  add_head(graph, shape, weights, features, {0, kDetectorMaps}, "maps");
  graph.output("maps", {1, kDetectorMaps, options.map_height(), options.map_width()});
  model.metadata["knuckle.kind"] = kDetectorFormat.name;
  model.metadata["knuckle.options"] = detector_options_as_toml(options);
  return model;
}

ExportedFile export_network(const std::filesystem::path& model, const std::filesystem::path& out) {
  std::error_code ignored;
  if (std::filesystem::equivalent(model, out, ignored))
    fail("{}: is the network itself; name another file to write", out.string());
  check_writable(out);
  NamedModel exported = model_of(ModelFile::open(model));
  const std::size_t nodes = exported.model.nodes.size();
  const std::int64_t weights = number_count(exported.model);
  const std::string bytes = onnx_bytes(exported.model);
  // What is written can be read and run again.
  (void)checked_onnx(parse_onnx(bytes, out.string()), out.string());
  write_text_file(out, bytes);
  return {std::move(exported.network), nodes, weights};
}

}  // namespace knuckle
