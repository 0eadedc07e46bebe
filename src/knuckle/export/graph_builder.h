// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle {

/// Adds nodes and constants to a graph, one after another. What a node makes has the node's name.
class GraphBuilder {
 public:
  explicit GraphBuilder(OnnxModel& model) : model_(model) {}

  using Attributes = std::map<std::string, OnnxAttribute>;

  /// Returns the name.
  std::string constant(const std::string& name, OnnxShape shape, std::vector<float> values) {
    model_.constants.insert_or_assign(name, real_tensor(std::move(shape), std::move(values)));
    return name;
  }
  /// A constant all of whose numbers are the same.
  std::string constant(const std::string& name, const OnnxShape& shape, float value) {
    return constant(name, shape, std::vector<float>(static_cast<std::size_t>(count_of(shape)), value));
  }
  std::string integers(const std::string& name, std::vector<std::int64_t> values) {
    model_.constants.insert_or_assign(name, integer_list(std::move(values)));
    return name;
  }

  /// Returns the name of what the node makes.
  std::string node(const std::string& operation, std::vector<std::string> inputs, const std::string& name,
                   Attributes attributes = {}) {
    model_.nodes.push_back({operation, name, std::move(inputs), {name}, std::move(attributes)});
    return name;
  }
  std::string reshape(const std::string& input, const std::string& name, OnnxShape shape) {
    return node("Reshape", {input, integers(name + ".shape", std::move(shape))}, name);
  }

  void input(const std::string& name, OnnxShape shape) { model_.inputs.push_back({name, std::move(shape)}); }
  void output(const std::string& name, OnnxShape shape) {
    model_.outputs.push_back({name, std::move(shape)});
  }

 private:
  OnnxModel& model_;
};

}  // namespace knuckle
