// SPDX-License-Identifier: Apache-2.0
// Operators that sum products or look at windows of pixels. Images are batch x channels x rows x columns.
#include <array>
#include <cmath>
#include <string_view>

#include "knuckle/net/onnx/node_view.h"

namespace knuckle {
namespace {

constexpr std::int64_t kMostSteps = 4096;  // of a kernel, a stride, a padding
constexpr double kMostScale = 64.0;

/// How a window moves over rows and columns.
struct Window {
  std::vector<std::int64_t> kernel, strides, dilations, pads;  // pads: before rows, columns, then after them
  bool is_same = false;                                        // padded so that only the stride shrinks
  bool is_lower = false;                                       // of that, an odd pixel comes before

  std::int64_t reach(std::size_t axis) const { return dilations[axis] * (kernel[axis] - 1) + 1; }
};

Window window_of(const NodeView& node, std::vector<std::int64_t> kernel) {
  Window window;
  if (kernel.empty()) kernel = node.integers("kernel_shape", {}, 1, kMostSteps);
  if (kernel.size() != 2) node.fault("its kernel has {} sizes, expected rows and columns", kernel.size());
  window.kernel = std::move(kernel);
  for (const std::int64_t size : window.kernel) {
    if (size < 1 || size > kMostSteps) node.fault("a kernel of {} pixels", size);
  }
  window.strides = node.integers("strides", {1, 1}, 1, kMostSteps);
  window.dilations = node.integers("dilations", {1, 1}, 1, kMostSteps);
  window.pads = node.integers("pads", {0, 0, 0, 0}, 0, kMostSteps);
  const std::string automatic = node.text("auto_pad", "NOTSET");
  window.is_lower = automatic == "SAME_LOWER";
  window.is_same = automatic == "SAME_UPPER" || window.is_lower;
  if (!window.is_same && automatic != "NOTSET" && automatic != "VALID")
    node.fault("auto_pad is '{}'", automatic);
  if (automatic != "NOTSET" && node.has_attribute("pads") && window.pads != std::vector<std::int64_t>(4, 0)) {
    node.fault("it has both pads and auto_pad");
  }
  return window;
}

std::int64_t places_of(const NodeView& node, const Window& window, std::int64_t size, std::size_t axis,
                       bool rounds_up) {
  const std::int64_t stride = window.strides[axis];
  if (window.is_same) {
    const std::int64_t places = (size + stride - 1) / stride;
    const std::int64_t padding = (places - 1) * stride + window.reach(axis) - size;
    // OpenCV puts the odd pixel behind.
    if (window.is_lower && padding > 0 && padding % 2 != 0)
      node.fault("SAME_LOWER with an odd padding of {} is not read; export it with pads", padding);
    return places;
  }
  const std::int64_t room = size + window.pads[axis] + window.pads[axis + 2] - window.reach(axis);
  if (room < 0) node.fault("a window of {} pixels in an image of {}", window.reach(axis), size);
  return (room + (rounds_up ? stride - 1 : 0)) / stride + 1;
}

/// Throws unless the bias, where there is one, has a number per output channel.
void check_bias(const NodeView& node, std::int64_t outputs) {
  if (!node.has(2)) return;
  const auto found = static_cast<std::int64_t>(node.reals(2).size());
  if (found != outputs) node.fault("its bias has {} numbers, expected {}", found, outputs);
}

/// The shape of the weights: four sizes, the last two of the kernel.
const OnnxShape& weights_of(const NodeView& node) {
  (void)node.reals(1);
  const OnnxShape& weights = node.shape(1, 4);
  const std::vector<std::int64_t> kernel = {weights[2], weights[3]};
  if (node.integers("kernel_shape", kernel, 1, kMostSteps) != kernel)
    node.fault("kernel_shape is not that of its weights");
  return weights;
}

OnnxShape checked(const NodeView& node, OnnxShape shape) {
  node.check_size(shape);
  return shape;
}

/// As the operator computes it: of a size the part below is dropped.
std::int64_t scaled(const NodeView& node, std::int64_t size, float scale) {
  if (!(scale > 0.0f && scale <= kMostScale))
    node.fault("it scales by {}, expected above 0, at most {}", scale, kMostScale);
  return static_cast<std::int64_t>(std::floor(static_cast<float>(size) * scale));
}

/// OpenCV wants to be told what the weights say.
void tell_kernel(NodeView& node, const Window& window) {
  node.node().attributes.insert_or_assign("kernel_shape", window.kernel);
}

}  // namespace

OnnxShape shape_of_convolution(NodeView& node) {
  const OnnxShape& input = node.shape(0, 4);
  const OnnxShape& weights = weights_of(node);
  const std::int64_t groups = node.integer("group", 1, 1, kMostSteps * kMostSteps);
  if (weights[1] != input[1] / groups || input[1] % groups != 0 || weights[0] % groups != 0) {
    node.fault("its weights are for {} x {} channels, its input has {}", weights[1], groups, input[1]);
  }
  check_bias(node, weights[0]);
  const Window window = window_of(node, {weights[2], weights[3]});
  tell_kernel(node, window);
  OnnxShape shape = checked(node, {input[0], weights[0], places_of(node, window, input[2], 0, false),
                                   places_of(node, window, input[3], 1, false)});
  node.count_work(count_of(shape), weights[1] * weights[2] * weights[3]);
  return shape;
}

OnnxShape shape_of_transposed_convolution(NodeView& node) {
  const OnnxShape& input = node.shape(0, 4);
  const OnnxShape& weights = weights_of(node);
  const std::int64_t groups = node.integer("group", 1, 1, kMostSteps * kMostSteps);
  if (weights[0] != input[1] || input[1] % groups != 0) {
    node.fault("its weights are for {} channels, its input has {}", weights[0], input[1]);
  }
  check_bias(node, weights[1] * groups);
  const Window window = window_of(node, {weights[2], weights[3]});
  tell_kernel(node, window);
  if (window.is_same) node.fault("auto_pad is not read here; export it with pads");
  const std::vector<std::int64_t> more = node.integers("output_padding", {0, 0}, 0, kMostSteps);
  std::array<std::int64_t, 2> sizes{};
  for (std::size_t i = 0; i < 2; ++i) {
    if (more[i] != 0 && more[i] >= window.strides[i]) node.fault("output_padding reaches the stride");
    sizes[i] = window.strides[i] * (input[i + 2] - 1) + more[i] + window.reach(i) - window.pads[i] -
               window.pads[i + 2];
  }
  OnnxShape shape = checked(node, {input[0], weights[1] * groups, sizes[0], sizes[1]});
  node.count_work(count_of(input), weights[1] * weights[2] * weights[3]);
  return shape;
}

OnnxShape shape_of_pool(NodeView& node) {
  const OnnxShape& input = node.shape(0, 4);
  const Window window = window_of(node, {});
  (void)node.integer("storage_order", 0, 0, 0);
  const bool is_padded = window.is_same || window.pads != std::vector<std::int64_t>(4, 0);
  if (node.integer("count_include_pad", 0, 0, 1) == 1 && is_padded) {
    node.fault(
        "count_include_pad is 1, which is not read where there are pads; export them as a Pad before it");
  }
  const bool rounds_up = node.integer("ceil_mode", 0, 0, 1) == 1;
  for (std::size_t i = 0; i < 4; ++i) {
    if (window.pads[i] >= window.kernel[i % 2]) node.fault("it is padded by its whole kernel");
    if (window.dilations[i % 2] != 1) node.fault("its kernel is dilated");
  }
  OnnxShape shape = checked(node, {input[0], input[1], places_of(node, window, input[2], 0, rounds_up),
                                   places_of(node, window, input[3], 1, rounds_up)});
  node.count_work(count_of(shape), window.kernel[0] * window.kernel[1]);
  return shape;
}

OnnxShape shape_of_global_pool(NodeView& node) {
  const OnnxShape& input = node.shape(0, 4);
  return {input[0], input[1], 1, 1};
}

OnnxShape shape_of_resize(NodeView& node) {
  const OnnxShape& input = node.shape(0, 4);
  const std::string mode = node.text("mode", "nearest");
  if (mode != "nearest" && mode != "linear" && mode != "bilinear") node.fault("the mode '{}'", mode);
  // What is meant where nothing is said; OpenCV wants it said.
  if (node.opset() >= 11) {
    node.node().attributes.emplace("coordinate_transformation_mode", std::string("half_pixel"));
  }
  const std::size_t scales_input = node.input_count() == 2 ? 1 : 2;
  OnnxShape shape = input;
  if (node.has(3)) {
    shape = node.integers(3);
    if (shape.size() != 4) node.fault("{} sizes, expected 4", shape.size());
  } else {
    const std::vector<float>& scales = node.reals(scales_input);
    if (scales.size() != 4) node.fault("{} scales, expected 4", scales.size());
    for (std::size_t i = 0; i < 4; ++i) shape[i] = scaled(node, input[i], scales[i]);
  }
  if (shape[0] != input[0] || shape[1] != input[1])
    node.fault("it scales channels, expected rows and columns");
  return checked(node, std::move(shape));
}

OnnxShape shape_of_gemm(NodeView& node) {
  const OnnxShape& a = node.shape(0, 2);
  (void)node.reals(1);
  const OnnxShape& b = node.shape(1, 2);
  (void)node.integer("transA", 0, 0, 0);
  const std::int64_t b_turned = node.integer("transB", 0, 0, 1);
  for (const char* factor : {"alpha", "beta"}) {
    const float value = node.real(factor, 1.0f);
    if (value != 1.0f) node.fault("{} is {}, expected 1; export it with its weights scaled", factor, value);
  }
  const std::int64_t inner = a[1];
  if (inner != (b_turned == 1 ? b[1] : b[0]))
    node.fault("matrices of {} x {} and {} x {}", a[0], a[1], b[0], b[1]);
  // Where nothing is said, OpenCV takes the second matrix as turned.
  node.node().attributes.insert_or_assign("transB", b_turned);
  OnnxShape shape = checked(node, {a[0], b_turned == 1 ? b[0] : b[1]});
  if (node.has(2)) {
    const auto found = static_cast<std::int64_t>(node.reals(2).size());
    if (found != 1 && found != shape[1]) node.fault("its bias has {} numbers, expected {}", found, shape[1]);
  }
  node.count_work(count_of(shape), inner);
  return shape;
}

OnnxShape shape_of_matmul(NodeView& node) {
  const OnnxShape& a = node.shape(0);
  const OnnxShape& b = node.shape(1);
  if (a.size() < 2 || b.size() < 2 || (b.size() != 2 && b.size() != a.size())) {
    node.fault("inputs of {} and {} sizes", a.size(), b.size());
  }
  const std::size_t rank = a.size();
  OnnxShape shape = a;
  for (std::size_t i = 0; b.size() == rank && i + 2 < rank; ++i) {
    if (a[i] != b[i]) node.fault("batches of {} and {} matrices", a[i], b[i]);
  }
  if (a[rank - 1] != b[b.size() - 2]) node.fault("{} columns times {} rows", a[rank - 1], b[b.size() - 2]);
  shape.back() = b.back();
  node.check_size(shape);
  node.count_work(count_of(shape), a[rank - 1]);
  return shape;
}

}  // namespace knuckle
