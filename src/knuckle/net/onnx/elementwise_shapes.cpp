// SPDX-License-Identifier: Apache-2.0
// Operators that work number by number, or channel by channel.
#include <algorithm>
#include <limits>

#include "knuckle/net/onnx/node_view.h"

namespace knuckle {
namespace {

/// As numpy broadcasts: sizes are compared from the last on, and those of 1 are stretched.
OnnxShape broadcast(const OnnxShape& a, const OnnxShape& b, const NodeView& node) {
  OnnxShape shape(std::max(a.size(), b.size()), 1);
  const auto size_at = [&](const OnnxShape& from, std::size_t i) {
    const std::size_t missing = shape.size() - from.size();
    return i < missing ? 1 : from[i - missing];
  };
  for (std::size_t i = 0; i < shape.size(); ++i) {
    const std::int64_t first = size_at(a, i);
    const std::int64_t second = size_at(b, i);
    if (first != second && first != 1 && second != 1) {
      node.fault("sizes {} and {} of its inputs do not fit together", first, second);
    }
    shape[i] = std::max(first, second);
  }
  return shape;
}

/// The bound of a Clip: an attribute, or since opset 11 an input.
float bound_of(const NodeView& node, std::size_t input, const std::string& name, float otherwise) {
  if (!node.has(input)) return node.real(name, otherwise);
  const std::vector<float>& values = node.reals(input);
  if (values.size() != 1) node.fault("{} has {} numbers, expected one", name, values.size());
  return values.front();
}

/// Throws unless the input is one number per channel.
void require_per_channel(const NodeView& node, std::size_t input, std::int64_t channels) {
  const auto found = static_cast<std::int64_t>(node.reals(input).size());
  if (found != channels)
    node.fault("input {} has {} numbers, expected one per channel ({})", input, found, channels);
}

}  // namespace

OnnxShape shape_of_same(NodeView& node) {
  return node.shape(0);
}

OnnxShape shape_of_clip(NodeView& node) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  const float low = bound_of(node, 1, "min", -kLargest);
  const float high = bound_of(node, 2, "max", kLargest);
  if (!(low <= high)) node.fault("it clips to [{}, {}]", low, high);
  node.become("Clip", {{"min", low}, {"max", high}});
  return node.shape(0);
}

/// Drops nothing in use.
OnnxShape shape_of_dropout(NodeView& node) {
  node.become("Identity", {});
  return node.shape(0);
}

OnnxShape shape_of_broadcast(NodeView& node) {
  OnnxShape shape = node.shape(0);
  for (std::size_t i = 1; i < node.input_count(); ++i) shape = broadcast(shape, node.shape(i), node);
  node.check_size(shape);
  return shape;
}

OnnxShape shape_of_prelu(NodeView& node) {
  const OnnxShape& shape = node.shape(0);
  const std::size_t slopes = node.reals(1).size();
  if (slopes != 1 && (shape.size() < 2 || static_cast<std::int64_t>(slopes) != shape[1])) {
    node.fault("it has {} slopes, expected one, or one per channel", slopes);
  }
  return shape;
}

OnnxShape shape_of_softmax(NodeView& node) {
  const OnnxShape& shape = node.shape(0);
  const bool is_old = node.opset() < 13;
  const std::size_t axis = node.axis("axis", is_old ? 1 : -1, shape.size());
  const auto behind = shape.begin() + static_cast<std::ptrdiff_t>(axis) + 1;
  if (is_old && std::any_of(behind, shape.end(), [](std::int64_t size) { return size != 1; })) {
    node.fault(
        "before opset 13 it takes the axes from {} on together; export it with opset_version=13 or later",
        axis);
  }
  // OpenCV has another default than either.
  node.node().attributes.insert_or_assign("axis", static_cast<std::int64_t>(axis));
  return shape;
}

OnnxShape shape_of_batch_norm(NodeView& node) {
  const OnnxShape& shape = node.shape(0);
  if (shape.size() < 2) node.fault("its input has {} sizes, expected channels at least", shape.size());
  for (std::size_t input = 1; input < 5; ++input) require_per_channel(node, input, shape[1]);
  (void)node.integer("spatial", 1, 1, 1);
  (void)node.integer("training_mode", 0, 0, 0);
  const float epsilon = node.real("epsilon", 1e-5f);
  if (!std::ranges::all_of(node.reals(4), [&](float variance) { return variance >= 0.0f; }) ||
      !(epsilon > 0.0f)) {
    node.fault("a variance is negative, or epsilon is not above 0");
  }
  return shape;
}

}  // namespace knuckle
