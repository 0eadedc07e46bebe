// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle::testing {

/// A model of one operation on the input `x`, whose other inputs are constants; it makes `y`.
inline OnnxModel one_node(std::string operation, OnnxShape input,
                          std::vector<std::pair<std::string, OnnxTensor>> constants = {},
                          std::map<std::string, OnnxAttribute> attributes = {}) {
  OnnxModel model;
  model.producer = "a test";
  model.graph_name = "graph";
  model.inputs = {{"x", std::move(input)}};
  model.outputs = {{"y", {}}};
  OnnxNode node{std::move(operation), "node", {"x"}, {"y"}, std::move(attributes)};
  for (auto& [name, tensor] : constants) {
    node.inputs.push_back(name);
    if (!name.empty()) model.constants[name] = std::move(tensor);
  }
  model.nodes = {std::move(node)};
  return model;
}

/// The model with another version of its operators: what newer ones take as inputs are attributes of older
/// ones.
inline OnnxModel of_opset(std::int64_t opset, OnnxModel model) {
  model.opset = opset;
  return model;
}

/// A tensor of that shape all of whose numbers are the same.
inline OnnxTensor filled(OnnxShape shape, float value = 0.5f) {
  const auto count = static_cast<std::size_t>(count_of(shape));
  return real_tensor(std::move(shape), std::vector<float>(count, value));
}

using Integers = std::vector<std::int64_t>;

/// What one model per operator of the list is tested with.
struct OperatorCase {
  OnnxModel model;
  OnnxShape output;
};

/// Each operator at least once, with the shape that it makes.
inline std::vector<OperatorCase> operator_cases() {
  const OnnxShape image = {1, 2, 6, 8};
  const OnnxShape row = {1, 1, 1, 6};
  const auto channels = [](float value) { return filled({2}, value); };
  std::vector<OperatorCase> cases;
  const auto add = [&](OnnxModel model, OnnxShape output) {
    cases.push_back({std::move(model), std::move(output)});
  };
  for (const char* name : {"Abs", "Elu", "Exp", "Identity", "LeakyRelu", "Neg", "Relu", "Sigmoid", "Softplus",
                           "Sqrt", "Tanh", "Dropout"}) {
    add(one_node(name, image), image);
  }
  for (const char* name : {"Add", "Sub", "Mul", "Div"}) {
    add(one_node(name, image, {{"c", filled({1})}}), image);
    add(one_node(name, image, {{"c", filled({1, 2, 6, 8})}}), image);
  }
  add(one_node("Clip", image, {{"low", filled({}, 0.0f)}, {"high", filled({}, 6.0f)}}), image);
  add(of_opset(9, one_node("Clip", image, {}, {{"min", 0.0f}, {"max", 6.0f}})), image);
  add(one_node("PRelu", image, {{"slope", filled({2, 1, 1})}}), image);
  add(one_node("Softmax", image, {}, {{"axis", std::int64_t{1}}}), image);
  add(one_node("BatchNormalization", image,
               {{"s", channels(2.0f)}, {"b", channels(0.1f)}, {"m", channels(0.2f)}, {"v", channels(4.0f)}}),
      image);
  add(one_node(
          "Conv", image, {{"w", filled({3, 2, 3, 3})}, {"b", filled({3})}},
          {{"kernel_shape", Integers{3, 3}}, {"strides", Integers{2, 2}}, {"pads", Integers{1, 1, 1, 1}}}),
      {1, 3, 3, 4});
  add(one_node("Conv", image, {{"w", filled({2, 1, 3, 3})}},
               {{"group", std::int64_t{2}}, {"dilations", Integers{2, 2}}}),
      {1, 2, 2, 4});
  add(one_node("Conv", image, {{"w", filled({1, 2, 3, 3})}}, {{"auto_pad", std::string("SAME_UPPER")}}),
      {1, 1, 6, 8});
  add(one_node("ConvTranspose", image, {{"w", filled({2, 3, 4, 4})}},
               {{"strides", Integers{2, 2}}, {"pads", Integers{1, 1, 1, 1}}}),
      {1, 3, 12, 16});
  add(one_node("MaxPool", image, {}, {{"kernel_shape", Integers{2, 2}}, {"strides", Integers{2, 2}}}),
      {1, 2, 3, 4});
  add(one_node("AveragePool", image, {}, {{"kernel_shape", Integers{3, 3}}, {"strides", Integers{2, 2}}}),
      {1, 2, 2, 3});
  add(one_node("GlobalAveragePool", image), {1, 2, 1, 1});
  add(one_node("GlobalMaxPool", image), {1, 2, 1, 1});
  add(one_node("Resize", image, {{"", {}}, {"s", real_tensor({4}, {1, 1, 2, 2})}},
               {{"mode", std::string("nearest")},
                {"coordinate_transformation_mode", std::string("asymmetric")},
                {"nearest_mode", std::string("floor")}}),
      {1, 2, 12, 16});
  add(one_node("Resize", image, {{"", {}}, {"", {}}, {"s", integer_list({1, 2, 12, 16})}},
               {{"mode", std::string("linear")}}),
      {1, 2, 12, 16});
  add(of_opset(9, one_node("Upsample", image, {{"s", real_tensor({4}, {1, 1, 2, 2})}},
                           {{"mode", std::string("nearest")}})),
      {1, 2, 12, 16});
  add(one_node("MatMul", row, {{"w", filled({6, 4})}}), {1, 1, 1, 4});
  add(one_node("Reshape", image, {{"s", integer_list({0, -1, 4})}}), {1, 24, 4});
  add(one_node("Flatten", image), {1, 96});
  add(one_node("Squeeze", row, {{"a", integer_list({1})}}), {1, 1, 6});
  add(of_opset(11, one_node("Squeeze", row, {}, {{"axes", Integers{-2, 1}}})), {1, 6});
  add(one_node("Unsqueeze", row, {{"a", integer_list({0})}}), {1, 1, 1, 1, 6});
  add(one_node("Transpose", image, {}, {{"perm", Integers{0, 2, 3, 1}}}), {1, 6, 8, 2});
  add(one_node("Concat", image, {{"c", filled({1, 3, 6, 8})}}, {{"axis", std::int64_t{1}}}), {1, 5, 6, 8});
  add(one_node("Slice", image,
               {{"s", integer_list({1, -4})}, {"e", integer_list({1000, -1})}, {"a", integer_list({1, 3})}}),
      {1, 1, 6, 3});
  add(one_node("Pad", image, {{"p", integer_list({0, 0, 1, 2, 0, 0, 3, 4})}}), {1, 2, 10, 14});
  for (const char* name : {"ReduceMax", "ReduceMean"}) {
    add(one_node(name, image, {}, {{"axes", Integers{2, 3}}, {"keepdims", std::int64_t{1}}}), {1, 2, 1, 1});
  }
  add(one_node("ReduceSum", image, {{"a", integer_list({2, 3})}}), {1, 2, 1, 1});
  OnnxModel gemm = one_node("Flatten", row);
  gemm.nodes.front().outputs = {"flat"};
  gemm.constants = {{"w", filled({4, 6})}, {"b", filled({4})}};
  gemm.nodes.push_back({"Gemm", "gemm", {"flat", "w", "b"}, {"y"}, {{"transB", std::int64_t{1}}}});
  add(std::move(gemm), {1, 4});
  return cases;
}

}  // namespace knuckle::testing
