// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx/node_view.h"

#include <algorithm>

namespace knuckle {
namespace {

/// The attribute of a type; null where it is missing. Throws where it is of another type.
template <class Value>
const Value* attribute(const OnnxNode& node, const std::string& name, const NodeView& view) {
  const auto found = node.attributes.find(name);
  if (found == node.attributes.end()) return nullptr;
  const auto* const value = std::get_if<Value>(&found->second);
  if (value == nullptr) view.fault("the attribute '{}' is of another type than expected", name);
  return value;
}

}  // namespace

const OnnxShape& NodeView::shape(std::size_t input) const {
  if (!has(input)) fault("input {} is missing", input);
  const std::string& name = node_.inputs[input];
  const auto computed = tensors_.shapes.find(name);
  if (computed != tensors_.shapes.end()) return computed->second;
  const auto constant = tensors_.constants->find(name);
  if (constant == tensors_.constants->end()) fault("it reads '{}', which nothing before it makes", name);
  if (constant->second.type != OnnxType::float32) fault("it computes with whole numbers, which is not done");
  if (constant->second.reals.empty()) fault("input {} is a constant without numbers", input);
  return constant->second.shape;
}

const OnnxShape& NodeView::shape(std::size_t input, std::size_t rank) const {
  const OnnxShape& found = shape(input);
  if (found.size() != rank) fault("input {} has {} sizes, expected {}", input, found.size(), rank);
  return found;
}

const OnnxTensor& NodeView::constant(std::size_t input) const {
  if (!has(input)) fault("input {} is missing", input);
  const auto found = tensors_.constants->find(node_.inputs[input]);
  if (found == tensors_.constants->end()) {
    fault("input {} ('{}') is no constant; export the network for one fixed size of its input", input,
          node_.inputs[input]);
  }
  return found->second;
}

const std::vector<float>& NodeView::reals(std::size_t input) const {
  const OnnxTensor& tensor = constant(input);
  if (tensor.type != OnnxType::float32) fault("input {} is not of real numbers", input);
  return tensor.reals;
}

const std::vector<std::int64_t>& NodeView::integers(std::size_t input) const {
  const OnnxTensor& tensor = constant(input);
  if (tensor.type != OnnxType::int64) fault("input {} is not of whole numbers", input);
  return tensor.integers;
}

std::int64_t NodeView::integer(const std::string& name, std::int64_t otherwise, std::int64_t low,
                               std::int64_t high) const {
  const auto* const found = attribute<std::int64_t>(node_, name, *this);
  const std::int64_t value = found != nullptr ? *found : otherwise;
  if (value < low || value > high) fault("{} is {}, expected {} to {}", name, value, low, high);
  return value;
}

std::vector<std::int64_t> NodeView::integers(const std::string& name, std::vector<std::int64_t> otherwise,
                                             std::int64_t low, std::int64_t high) const {
  const auto* const found = attribute<std::vector<std::int64_t>>(node_, name, *this);
  if (found == nullptr) return otherwise;
  if (!otherwise.empty() && found->size() != otherwise.size()) {
    fault("{} has {} numbers, expected {}", name, found->size(), otherwise.size());
  }
  for (const std::int64_t value : *found) {
    if (value < low || value > high) fault("{} has {}, expected {} to {}", name, value, low, high);
  }
  return *found;
}

std::string NodeView::text(const std::string& name, const std::string& otherwise) const {
  const auto* const found = attribute<std::string>(node_, name, *this);
  return found != nullptr ? *found : otherwise;
}

float NodeView::real(const std::string& name, float otherwise) const {
  const auto* const found = attribute<float>(node_, name, *this);
  return found != nullptr ? *found : otherwise;
}

std::size_t NodeView::axis(const std::string& name, std::int64_t otherwise, std::size_t rank) const {
  const auto* const found = attribute<std::int64_t>(node_, name, *this);
  return place_of(found != nullptr ? *found : otherwise, rank);
}

std::size_t NodeView::place_of(std::int64_t axis, std::size_t rank) const {
  const auto sizes = static_cast<std::int64_t>(rank);
  if (axis < -sizes || axis >= sizes) fault("axis {} of a tensor that has {} sizes", axis, rank);
  return static_cast<std::size_t>(axis < 0 ? axis + sizes : axis);
}

void NodeView::check_size(const OnnxShape& shape) const {
  std::int64_t count = 1;
  for (const std::int64_t size : shape) {
    if (size < 1) fault("a tensor it makes has a size of {}", size);
    if (size > tensors_.most_numbers / count) {
      fault("a tensor it makes has more than {} numbers, which is too many", tensors_.most_numbers);
    }
    count *= size;
  }
}

void NodeView::count_work(std::int64_t outputs, std::int64_t products_per_output) {
  work_ += static_cast<double>(outputs) * static_cast<double>(products_per_output);
}

OnnxShape NodeView::become_reshape(OnnxShape shape) {
  check_size(shape);
  become("Reshape", {});
  const std::string name = "knuckle:shape:" + node_.outputs.front();
  if (tensors_.shapes.contains(name) || !tensors_.constants->emplace(name, integer_list(shape)).second) {
    fault("'{}' is a name of ours", name);
  }
  node_.inputs.push_back(name);
  return shape;
}

void NodeView::become(std::string operation, std::map<std::string, OnnxAttribute> attributes) {
  node_.operation = std::move(operation);
  node_.attributes = std::move(attributes);
  node_.inputs.resize(1);
}

}  // namespace knuckle
