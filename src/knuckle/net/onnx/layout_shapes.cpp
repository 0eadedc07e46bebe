// SPDX-License-Identifier: Apache-2.0
// Operators that only move numbers, or take whole axes together.
#include <algorithm>
#include <limits>
#include <numeric>

#include "knuckle/net/onnx/node_view.h"

namespace knuckle {
namespace {

constexpr std::int64_t kLowestInteger = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kHighestInteger = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMostPadding = 4096;

/// A list that newer opsets give as an input and older ones as an attribute; `otherwise` where it is neither.
std::vector<std::int64_t> list_of(const NodeView& node, std::size_t input, const std::string& name,
                                  const std::vector<std::int64_t>& otherwise) {
  if (node.has(input)) return node.integers(input);
  return node.has_attribute(name) ? node.integers(name, {}, kLowestInteger, kHighestInteger) : otherwise;
}

/// Which of `rank` axes the list names, each at most once.
std::vector<bool> marked(const NodeView& node, const std::vector<std::int64_t>& axes, std::size_t rank) {
  std::vector<bool> marks(rank, false);
  for (const std::int64_t axis : axes) {
    const std::size_t place = node.place_of(axis, rank);
    if (marks[place]) node.fault("it names an axis twice");
    marks[place] = true;
  }
  return marks;
}

/// A place of an axis of `size` that counts from the end where it is negative, cut to [0, size].
std::int64_t cut(std::int64_t place, std::int64_t size) {
  if (place < 0) place = place < -size ? 0 : place + size;
  return std::min(place, size);
}

}  // namespace

OnnxShape shape_of_reshape(NodeView& node) {
  const OnnxShape& input = node.shape(0);
  (void)node.integer("allowzero", 0, 0, 0);
  OnnxShape shape = node.integers(1);
  std::size_t open = shape.size();
  std::int64_t known = 1;
  const std::int64_t count = count_of(input);
  for (std::size_t i = 0; i < shape.size(); ++i) {
    if (shape[i] == 0) {
      if (i >= input.size()) node.fault("it keeps size {} of {}", i, input.size());
      shape[i] = input[i];
    }
    if (shape[i] == -1) {
      if (open != shape.size()) node.fault("two of its sizes are open");
      open = i;
      continue;
    }
    if (shape[i] < 1 || shape[i] > count) node.fault("a size of {} for {} numbers", shape[i], count);
    known *= shape[i];
    if (known > count) node.fault("a shape of more than {} numbers for {}", count, count);
  }
  if (open != shape.size()) {
    shape[open] = count / known;
    known *= shape[open];
  }
  if (known != count) node.fault("a shape of {} numbers for {}", known, count);
  return node.become_reshape(std::move(shape));
}

OnnxShape shape_of_flatten(NodeView& node) {
  const OnnxShape& input = node.shape(0);
  const auto rank = static_cast<std::int64_t>(input.size());
  const std::int64_t axis = node.integer("axis", 1, -rank, rank);
  const std::size_t place = static_cast<std::size_t>(axis < 0 ? axis + rank : axis);
  OnnxShape shape = {1, 1};
  for (std::size_t i = 0; i < input.size(); ++i) shape[i < place ? 0 : 1] *= input[i];
  return node.become_reshape(std::move(shape));
}

OnnxShape shape_of_squeeze(NodeView& node) {
  const OnnxShape& input = node.shape(0);
  std::vector<std::int64_t> ones;
  for (std::size_t i = 0; i < input.size(); ++i) {
    if (input[i] == 1) ones.push_back(static_cast<std::int64_t>(i));
  }
  const std::vector<bool> marks = marked(node, list_of(node, 1, "axes", ones), input.size());
  OnnxShape shape;
  for (std::size_t i = 0; i < input.size(); ++i) {
    if (!marks[i]) {
      shape.push_back(input[i]);
    } else if (input[i] != 1) {
      node.fault("it takes away a size of {}", input[i]);
    }
  }
  return node.become_reshape(std::move(shape));
}

OnnxShape shape_of_unsqueeze(NodeView& node) {
  const OnnxShape& input = node.shape(0);
  const std::vector<std::int64_t> axes = list_of(node, 1, "axes", {});
  constexpr std::size_t kMostSizesAfter = 8;
  if (axes.empty() || axes.size() + input.size() > kMostSizesAfter)
    node.fault("it adds {} sizes", axes.size());
  const std::vector<bool> marks = marked(node, axes, axes.size() + input.size());
  OnnxShape shape;
  auto next = input.begin();
  for (const bool is_new : marks) shape.push_back(is_new ? 1 : *next++);
  return node.become_reshape(std::move(shape));
}

OnnxShape shape_of_transpose(NodeView& node) {
  const OnnxShape& input = node.shape(0);
  std::vector<std::int64_t> order(input.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int64_t>(order.size() - 1 - i);
  order = node.integers("perm", order, 0, static_cast<std::int64_t>(input.size()) - 1);
  (void)marked(node, order, input.size());
  OnnxShape shape;
  for (const std::int64_t axis : order) shape.push_back(input[static_cast<std::size_t>(axis)]);
  return shape;
}

OnnxShape shape_of_concat(NodeView& node) {
  OnnxShape shape = node.shape(0);
  if (shape.empty()) node.fault("it joins single numbers");
  if (!node.has_attribute("axis")) node.fault("it has no axis");
  const std::size_t axis = node.axis("axis", 0, shape.size());
  for (std::size_t i = 1; i < node.input_count(); ++i) {
    OnnxShape other = node.shape(i, shape.size());
    const std::int64_t size = other[axis];
    other[axis] = shape[axis];
    if (other != shape) node.fault("input {} has another shape than the first", i);
    shape[axis] += size;
    node.check_size(shape);
  }
  return shape;
}

OnnxShape shape_of_slice(NodeView& node) {
  OnnxShape shape = node.shape(0);
  const std::vector<std::int64_t> starts = list_of(node, 1, "starts", {});
  const std::vector<std::int64_t> ends = list_of(node, 2, "ends", {});
  std::vector<std::int64_t> axes;
  for (std::size_t i = 0; i < starts.size(); ++i) axes.push_back(static_cast<std::int64_t>(i));
  axes = list_of(node, 3, "axes", axes);
  const std::vector<std::int64_t> steps = list_of(node, 4, "steps", {});
  if (starts.size() != ends.size() || starts.size() != axes.size())
    node.fault("starts, ends and axes differ in number");
  if (std::ranges::any_of(steps, [](std::int64_t step) { return step != 1; }))
    node.fault("it takes steps other than 1");
  (void)marked(node, axes, shape.size());
  // Of all axes in their order, as OpenCV wants it.
  std::vector<std::int64_t> all_axes(shape.size());
  std::iota(all_axes.begin(), all_axes.end(), 0);
  std::vector<std::int64_t> all_starts(shape.size(), 0);
  std::vector<std::int64_t> all_ends = shape;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::size_t place = node.place_of(axes[i], shape.size());
    all_starts[place] = cut(starts[i], shape[place]);
    all_ends[place] = cut(ends[i], shape[place]);
  }
  for (std::size_t i = 0; i < shape.size(); ++i) shape[i] = all_ends[i] - all_starts[i];
  node.check_size(shape);
  node.become("Slice", {{"starts", all_starts}, {"ends", all_ends}, {"axes", all_axes}});
  return shape;
}

OnnxShape shape_of_pad(NodeView& node) {
  OnnxShape shape = node.shape(0);
  const std::string mode = node.text("mode", "constant");
  if (mode != "constant" && mode != "reflect")
    node.fault("the mode '{}', expected constant or reflect", mode);
  const std::vector<std::int64_t> pads = list_of(node, 1, "pads", {});
  if (pads.size() != 2 * shape.size()) node.fault("{} pads, expected {}", pads.size(), 2 * shape.size());
  if (node.has(2) && node.reals(2).size() != 1) node.fault("it pads with {} values", node.reals(2).size());
  for (std::size_t i = 0; i < pads.size(); ++i) {
    std::int64_t& size = shape[i % shape.size()];
    const std::int64_t most =
        mode == "reflect" ? std::min(kMostPadding, node.shape(0)[i % shape.size()] - 1) : kMostPadding;
    if (pads[i] < 0 || pads[i] > most) node.fault("it pads by {}, expected 0 to {}", pads[i], most);
    size += pads[i];
  }
  node.check_size(shape);
  return shape;
}

OnnxShape shape_of_reduce(NodeView& node) {
  const OnnxShape& input = node.shape(0);
  const bool keeps = node.integer("keepdims", 1, 0, 1) == 1;
  if (node.integer("noop_with_empty_axes", 0, 0, 1) == 1) node.fault("noop_with_empty_axes is not read");
  std::vector<std::int64_t> axes = list_of(node, 1, "axes", {});
  if (axes.empty()) {
    axes.resize(input.size());
    std::iota(axes.begin(), axes.end(), 0);
  }
  const std::vector<bool> marks = marked(node, axes, input.size());
  OnnxShape shape;
  for (std::size_t i = 0; i < input.size(); ++i) {
    if (!marks[i]) {
      shape.push_back(input[i]);
    } else if (keeps) {
      shape.push_back(1);
    }
  }
  node.become(node.node().operation, {{"axes", axes}, {"keepdims", std::int64_t{keeps ? 1 : 0}}});
  return shape;
}

}  // namespace knuckle
