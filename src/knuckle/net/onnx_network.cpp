// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx_network.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/net/layers/workspace_pool.h"
#include "knuckle/net/onnx/onnx_check.h"
#include "knuckle/net/onnx/onnx_engine.h"

namespace knuckle {

/// The model, and engines that run it: one for each thread that asks.
struct OnnxNetwork::Content {
  Content(OnnxModel unchecked, const std::string& name)
      : model(checked_onnx(std::move(unchecked), name)),
        origin(name),
        engines([this] { return create_onnx_engine(model, origin); }) {}

  OnnxModel model;
  std::string origin;
  WorkspacePool<std::unique_ptr<OnnxEngine>> engines;
};

OnnxNetwork::OnnxNetwork(OnnxModel model, const std::string& origin)
    : content_(std::make_unique<const Content>(std::move(model), origin)) {
  const std::vector<float> zeros(static_cast<std::size_t>(count_of(input_shape())), 0.0f);
  (void)run(zeros);
}

OnnxNetwork::OnnxNetwork(OnnxNetwork&&) noexcept = default;
OnnxNetwork& OnnxNetwork::operator=(OnnxNetwork&&) noexcept = default;
OnnxNetwork::~OnnxNetwork() = default;

const std::string& OnnxNetwork::origin() const {
  return content_->origin;
}

const OnnxShape& OnnxNetwork::input_shape() const {
  return content_->model.inputs.front().shape;
}

const std::vector<OnnxValue>& OnnxNetwork::outputs() const {
  return content_->model.outputs;
}

int OnnxNetwork::output_named(std::string_view name) const {
  const auto found = std::ranges::find(outputs(), name, &OnnxValue::name);
  return found == outputs().end() ? -1 : static_cast<int>(found - outputs().begin());
}

std::vector<std::vector<float>> OnnxNetwork::run(std::span<const float> input) const {
  auto results = content_->engines.with_workspace([&](std::unique_ptr<OnnxEngine>& engine) {
    try {
      return engine->run(input);
    } catch (const std::runtime_error& error) {
      fail("{}: {} cannot run it: {}", origin(), onnx_support().text, error.what());
    }
  });
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!std::ranges::all_of(results[i], [](float value) { return std::isfinite(value); })) {
      fail("{}: a number of its output '{}' is not finite", origin(), outputs()[i].name);
    }
  }
  return results;
}

}  // namespace knuckle
