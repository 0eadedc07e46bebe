// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx/onnx_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/named_table.h"
#include "knuckle/net/onnx/node_view.h"

namespace knuckle {
namespace {

constexpr std::size_t kMany = 256;     // inputs of a node
constexpr std::size_t kMostSizes = 8;  // of a tensor

constexpr std::array kOperators{
    OnnxOperator{"Abs", 1, 1, "", shape_of_same},
    OnnxOperator{"Add", 2, 2, "", shape_of_broadcast},
    OnnxOperator{"AveragePool", 1, 1, "kernel_shape strides pads auto_pad ceil_mode count_include_pad",
                 shape_of_pool},
    OnnxOperator{"BatchNormalization", 5, 5, "epsilon momentum spatial training_mode", shape_of_batch_norm},
    OnnxOperator{"Clip", 1, 3, "min max", shape_of_clip},
    OnnxOperator{"Concat", 1, kMany, "axis", shape_of_concat},
    OnnxOperator{"Conv", 2, 3, "kernel_shape strides pads dilations auto_pad group", shape_of_convolution},
    OnnxOperator{"ConvTranspose", 2, 3, "kernel_shape strides pads dilations auto_pad group output_padding",
                 shape_of_transposed_convolution},
    OnnxOperator{"Div", 2, 2, "", shape_of_broadcast},
    OnnxOperator{"Dropout", 1, 3, "ratio seed", shape_of_dropout},
    OnnxOperator{"Elu", 1, 1, "alpha", shape_of_same},
    OnnxOperator{"Exp", 1, 1, "", shape_of_same},
    OnnxOperator{"Flatten", 1, 1, "axis", shape_of_flatten},
    OnnxOperator{"Gemm", 2, 3, "alpha beta transA transB", shape_of_gemm},
    OnnxOperator{"GlobalAveragePool", 1, 1, "", shape_of_global_pool},
    OnnxOperator{"GlobalMaxPool", 1, 1, "", shape_of_global_pool},
    OnnxOperator{"Identity", 1, 1, "", shape_of_same},
    OnnxOperator{"LeakyRelu", 1, 1, "alpha", shape_of_same},
    OnnxOperator{"MatMul", 2, 2, "", shape_of_matmul},
    OnnxOperator{"MaxPool", 1, 1, "kernel_shape strides pads dilations auto_pad ceil_mode storage_order",
                 shape_of_pool},
    OnnxOperator{"Mul", 2, 2, "", shape_of_broadcast},
    OnnxOperator{"Neg", 1, 1, "", shape_of_same},
    OnnxOperator{"PRelu", 2, 2, "", shape_of_prelu},
    OnnxOperator{"Pad", 1, 3, "mode pads value", shape_of_pad},
    OnnxOperator{"ReduceMax", 1, 1, "axes keepdims", shape_of_reduce},
    OnnxOperator{"ReduceMean", 1, 1, "axes keepdims", shape_of_reduce},
    OnnxOperator{"ReduceSum", 1, 2, "axes keepdims noop_with_empty_axes", shape_of_reduce},
    OnnxOperator{"Relu", 1, 1, "", shape_of_same},
    OnnxOperator{"Reshape", 2, 2, "allowzero", shape_of_reshape},
    OnnxOperator{"Resize", 2, 4,
                 "mode coordinate_transformation_mode nearest_mode cubic_coeff_a exclude_outside "
                 "extrapolation_value",
                 shape_of_resize},
    OnnxOperator{"Sigmoid", 1, 1, "", shape_of_same},
    OnnxOperator{"Slice", 1, 5, "starts ends axes", shape_of_slice},
    OnnxOperator{"Softmax", 1, 1, "axis", shape_of_softmax},
    OnnxOperator{"Softplus", 1, 1, "", shape_of_same},
    OnnxOperator{"Sqrt", 1, 1, "", shape_of_same},
    OnnxOperator{"Squeeze", 1, 2, "axes", shape_of_squeeze},
    OnnxOperator{"Sub", 2, 2, "", shape_of_broadcast},
    OnnxOperator{"Tanh", 1, 1, "", shape_of_same},
    OnnxOperator{"Transpose", 1, 1, "perm", shape_of_transpose},
    OnnxOperator{"Unsqueeze", 1, 2, "axes", shape_of_unsqueeze},
    OnnxOperator{"Upsample", 2, 2, "mode", shape_of_resize},
};

constexpr auto kNames = names_of(kOperators);

class OnnxChecker {
 public:
  OnnxChecker(OnnxModel model, const std::string& origin, const OnnxLimits& limits)
      : model_(std::move(model)), origin_(origin), limits_(limits) {
    tensors_.constants = &model_.constants;
    tensors_.opset = model_.opset;
    tensors_.most_numbers = limits.numbers;
  }

  OnnxModel checked() {
    check_opset();
    check_constants();
    add_inputs();
    take_constants_from_nodes();
    for (OnnxNode& node : model_.nodes) check_node(node);
    close_outputs();
    copy_input_for_concat();
    return std::move(model_);
  }

 private:
  void check_opset() const {
    if (model_.opset < kOldestOpset || model_.opset > kNewestOpset) {
      fail("{}: its operators are of opset {}, expected {} to {}; export the network with opset_version={}",
           origin_, model_.opset, kOldestOpset, kNewestOpset, kNewestOpset);
    }
  }

  void check_constants() {
    for (const auto& [name, tensor] : model_.constants) {
      check_constant(tensor, fmt::format("{}: the constant '{}'", origin_, name));
    }
  }

  static void check_constant(const OnnxTensor& tensor, const std::string& what) {
    if (!std::ranges::all_of(tensor.reals, [](float value) { return std::isfinite(value); })) {
      fail("{} holds a number that is not finite", what);
    }
  }

  void add_inputs() {
    if (model_.inputs.size() != 1) {
      fail("{}: it has {} inputs, expected one, the patch", origin_, model_.inputs.size());
    }
    OnnxValue& input = model_.inputs.front();
    if (input.shape.size() != 4) {
      fail(
          "{}: its input '{}' has {} sizes, expected 4 (batch, and channels, rows and columns in some order)",
          origin_, input.name, input.shape.size());
    }
    if (input.shape.front() == kOpenSize) input.shape.front() = 1;
    for (const std::int64_t size : input.shape) {
      if (size < 1 || size > limits::kImageSide) {
        fail("{}: its input '{}' has a size that is {}; export the network for one fixed size", origin_,
             input.name, size == kOpenSize ? "left open" : fmt::format("{}", size));
      }
    }
    add_tensor(input.name, input.shape, fmt::format("{}: the input", origin_));
  }

  /// `Constant` nodes become constants of the model.
  void take_constants_from_nodes() {
    for (OnnxNode& node : model_.nodes) {
      if (node.operation != "Constant") continue;
      const std::string what = what_of(node);
      if (node.attributes.size() != 1 || node.outputs.size() != 1)
        fail("{}: expected one value and one output", what);
      check_is_new(node.outputs.front(), what);
      model_.constants.emplace(node.outputs.front(), constant_in(node, what));
    }
    std::erase_if(model_.nodes, [](const OnnxNode& node) { return node.operation == "Constant"; });
  }

  static OnnxTensor constant_in(OnnxNode& node, const std::string& what) {
    auto& [name, value] = *node.attributes.begin();
    if (auto* const tensor = std::get_if<OnnxTensor>(&value); tensor != nullptr && name == "value") {
      check_constant(*tensor, what);
      return std::move(*tensor);
    }
    fail("{}: the attribute '{}', expected a tensor 'value'", what, name);
  }

  std::string what_of(const OnnxNode& node) const {
    return fmt::format("{}: node '{}' ({})", origin_, node.name, node.operation);
  }

  void check_node(OnnxNode& node) {
    const std::string what = what_of(node);
    const OnnxOperator* const found = row_named(kOperators, node.operation);
    if (found == nullptr)
      fail("{}: an operator that is not on the list of those that are run (docs/onnx.md)", what);
    check_form(node, *found, what);
    NodeView view(node, tensors_, what);
    OnnxShape shape = found->output_shape(view);
    if (shape.empty() || shape.size() > kMostSizes) {
      view.fault("a tensor it makes has {} sizes, expected 1 to {}", shape.size(), kMostSizes);
    }
    view.check_size(shape);
    work_ += view.work();
    if (work_ > static_cast<double>(limits_.work)) {
      fail("{}: up to here an answer takes {:.1e} multiplications, expected at most {:.1e}", what, work_,
           static_cast<double>(limits_.work));
    }
    add_tensor(node.outputs.front(), std::move(shape), what);
    node.name = node.outputs.front();  // OpenCV wants names that are there once
  }

  /// Numbers of inputs and outputs, and the names of attributes. Optional outputs that nobody asks for go.
  void check_form(OnnxNode& node, const OnnxOperator& expected, const std::string& what) const {
    while (!node.inputs.empty() && node.inputs.back().empty()) node.inputs.pop_back();
    if (node.inputs.size() < expected.least_inputs || node.inputs.size() > expected.most_inputs) {
      fail("{}: {} inputs, expected {} to {}", what, node.inputs.size(), expected.least_inputs,
           expected.most_inputs);
    }
    if (std::ranges::none_of(node.inputs, [&](const auto& name) { return tensors_.shapes.contains(name); })) {
      fail("{}: nothing before it makes an input of it, or all are constants; export with constants folded",
           what);
    }
    if (node.outputs.empty() || node.outputs.front().empty()) fail("{}: it has no output", what);
    if (expected.name == "Dropout" || expected.name == "BatchNormalization") node.outputs.resize(1);
    if (node.outputs.size() != 1) fail("{}: {} outputs, expected one", what, node.outputs.size());
    const std::vector<std::string_view> known = split(expected.attributes, ' ');
    for (const auto& [name, value] : node.attributes) {
      if (!std::ranges::count(known, name)) fail("{}: the attribute '{}' is not known here", what, name);
      const auto* const real = std::get_if<float>(&value);
      if (real != nullptr && !std::isfinite(*real)) fail("{}: the attribute '{}' is not finite", what, name);
    }
  }

  void check_is_new(const std::string& name, const std::string& what) const {
    if (name.empty()) fail("{}: a tensor without a name", what);
    if (tensors_.shapes.contains(name) || model_.constants.contains(name)) {
      fail("{}: it makes '{}', which is there already", what, name);
    }
  }

  void add_tensor(const std::string& name, OnnxShape shape, const std::string& what) {
    check_is_new(name, what);
    numbers_ += count_of(shape);
    if (numbers_ > limits_.numbers) {
      fail("{}: up to here an answer takes {} MB, expected at most {} MB", what, numbers_ >> 18,
           limits_.numbers >> 18);
    }
    tensors_.shapes.emplace(name, std::move(shape));
  }

  void close_outputs() {
    if (model_.outputs.empty()) fail("{}: it has no output", origin_);
    std::set<std::string> names;
    for (OnnxValue& output : model_.outputs) {
      const auto found = tensors_.shapes.find(output.name);
      if (found == tensors_.shapes.end()) fail("{}: no node makes its output '{}'", origin_, output.name);
      if (!names.insert(output.name).second) fail("{}: the output '{}' is there twice", origin_, output.name);
      output.shape = found->second;
    }
  }

  /// OpenCV 4.6 loses the input where it is joined with constants: it is joined as a copy, itself times 1.
  void copy_input_for_concat() {
    const std::string input = model_.inputs.front().name;
    const std::string copy = "knuckle:copy:" + input;
    bool is_needed = false;
    for (OnnxNode& node : model_.nodes) {
      if (node.operation != "Concat" || !std::ranges::count(node.inputs, input)) continue;
      std::ranges::replace(node.inputs, input, copy);
      is_needed = true;
    }
    if (!is_needed) return;
    const std::string what = origin_ + ": a copy of the input";
    const std::string one = "knuckle:one";
    check_is_new(one, what);
    add_tensor(copy, model_.inputs.front().shape, what);
    model_.constants.emplace(one, real_tensor({1}, {1.0f}));
    model_.nodes.insert(model_.nodes.begin(), {"Mul", copy, {input, one}, {copy}});
  }

  OnnxModel model_;
  const std::string& origin_;
  OnnxLimits limits_;
  OnnxTensors tensors_;
  std::int64_t numbers_ = 0;
  double work_ = 0.0;
};

}  // namespace

std::span<const std::string_view> onnx_operators() {
  return kNames;
}

OnnxModel checked_onnx(OnnxModel model, const std::string& origin, const OnnxLimits& limits) {
  return OnnxChecker(std::move(model), origin, limits).checked();
}

}  // namespace knuckle
