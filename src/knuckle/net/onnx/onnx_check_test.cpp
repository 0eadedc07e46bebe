// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx/onnx_check.h"

#include <algorithm>
#include <limits>
#include <set>

#include "knuckle/core/testing.h"
#include "knuckle/net/onnx/onnx_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::error_of;
using testing::filled;
using ::testing::HasSubstr;
using testing::Integers;
using testing::of_opset;
using testing::one_node;

const OnnxShape kImage = {1, 2, 6, 8};

std::string fault(const OnnxModel& model, const OnnxLimits& limits = {}) {
  return error_of([&] { (void)checked_onnx(model, "net.onnx", limits); });
}

TEST(OnnxCheck, KnowsTheShapesThatOperatorsMake) {
  std::set<std::string, std::less<>> seen;
  for (const testing::OperatorCase& known : testing::operator_cases()) {
    const std::string operation = known.model.nodes.back().operation;
    seen.insert(operation);
    SCOPED_TRACE(operation);
    EXPECT_EQ(checked_onnx(known.model, "net.onnx").outputs.front().shape, known.output);
  }
  for (const std::string_view name : onnx_operators())
    EXPECT_TRUE(seen.contains(name)) << name << " has no case";
}

TEST(OnnxCheck, APoolRoundsItsSizesUpWhereItSaysSo) {
  const auto pooled = [](std::int64_t ceil_mode) {
    const OnnxModel model =
        one_node("MaxPool", kImage, {},
                 {{"kernel_shape", Integers{3, 3}}, {"strides", Integers{2, 2}}, {"ceil_mode", ceil_mode}});
    return checked_onnx(model, "net.onnx").outputs.front().shape;
  };
  EXPECT_THAT(pooled(0), ElementsAre(1, 2, 2, 3));
  EXPECT_THAT(pooled(1), ElementsAre(1, 2, 3, 4));
}

TEST(OnnxCheck, WhatIsOpenAtFirstIsOne) {
  EXPECT_THAT(checked_onnx(one_node("Relu", {kOpenSize, 1, 4, 4}), "net.onnx").inputs.front().shape,
              ElementsAre(1, 1, 4, 4));
  EXPECT_THAT(fault(one_node("Relu", {1, 1, kOpenSize, 4})),
              AllOf(HasSubstr("left open"), HasSubstr("fixed size")));
}

TEST(OnnxCheck, OperatorsAndVersionsAreThoseOfTheList) {
  EXPECT_THAT(fault(one_node("NonMaxSuppression", kImage)),
              AllOf(HasSubstr("net.onnx: node 'node' (NonMaxSuppression)"), HasSubstr("not on the list")));
  EXPECT_THAT(fault(one_node("Loop", kImage)), HasSubstr("Loop"));
  OnnxModel later = one_node("Relu", kImage);
  later.opset = 21;
  EXPECT_THAT(fault(later), AllOf(HasSubstr("opset 21"), HasSubstr("opset_version=17")));
  later.opset = 8;
  EXPECT_THAT(fault(later), HasSubstr("opset 8"));
  EXPECT_THAT(fault(one_node("Relu", kImage, {}, {{"alpha", 1.0f}})), HasSubstr("'alpha' is not known"));
}

TEST(OnnxCheck, ConstantNodesBecomeConstants) {
  OnnxModel model = one_node("Add", kImage);
  model.nodes.front().inputs = {"x", "c"};
  model.nodes.insert(model.nodes.begin(), {"Constant", "constant", {}, {"c"}, {{"value", filled({1})}}});
  const OnnxModel checked = checked_onnx(model, "net.onnx");
  EXPECT_EQ(checked.nodes.size(), 1u);
  EXPECT_TRUE(checked.constants.contains("c"));
}

TEST(OnnxCheck, IsWrittenAsOpenCvUnderstandsIt) {
  const OnnxModel clip =
      checked_onnx(one_node("Clip", kImage, {{"l", filled({}, 0.0f)}, {"h", filled({}, 6.0f)}}), "n");
  EXPECT_EQ(clip.nodes.front().inputs.size(), 1u);
  EXPECT_EQ(std::get<float>(clip.nodes.front().attributes.at("max")), 6.0f);
  const OnnxModel flat = checked_onnx(one_node("Flatten", kImage), "n");
  EXPECT_EQ(flat.nodes.front().operation, "Reshape");
  EXPECT_THAT(flat.constants.at(flat.nodes.front().inputs[1]).integers, ElementsAre(1, 96));
}

TEST(OnnxCheck, ATensorMustBeMadeBeforeItIsRead) {
  OnnxModel model = one_node("Add", kImage);
  model.nodes.front().inputs = {"x", "later"};
  EXPECT_THAT(fault(model), HasSubstr("reads 'later', which nothing before it makes"));
  model = one_node("Relu", kImage);
  model.nodes.front().inputs = {"y"};  // its own output
  EXPECT_THAT(fault(model), HasSubstr("nothing before it makes"));
  model = one_node("Relu", kImage);
  model.nodes.front().outputs = {"x"};
  EXPECT_THAT(fault(model), HasSubstr("makes 'x', which is there already"));
  model = one_node("Relu", kImage);
  model.outputs.front().name = "z";
  EXPECT_THAT(fault(model), HasSubstr("no node makes its output 'z'"));
  model = one_node("Add", kImage, {{"a", filled({1})}});
  model.nodes.front().inputs = {"a", "a"};
  EXPECT_THAT(fault(model), HasSubstr("constants"));
}

TEST(OnnxCheck, WhatDoesNotFitTogetherIsSaid) {
  EXPECT_THAT(fault(one_node("Add", kImage, {{"c", filled({3})}})), HasSubstr("sizes 8 and 3"));
  EXPECT_THAT(fault(one_node("Conv", kImage, {{"w", filled({3, 1, 3, 3})}})), HasSubstr("1 x 1 channels"));
  EXPECT_THAT(fault(one_node("Conv", kImage, {{"w", filled({3, 2, 7, 7})}})),
              HasSubstr("window of 7 pixels"));
  EXPECT_THAT(fault(one_node("Conv", kImage, {{"w", filled({3, 2, 3, 3})}, {"b", filled({4})}})),
              HasSubstr("bias"));
  EXPECT_THAT(fault(one_node("Conv", kImage, {{"w", filled({3, 2, 3, 3})}}, {{"strides", Integers{0, 1}}})),
              HasSubstr("strides has 0"));
  EXPECT_THAT(fault(one_node("Conv", kImage, {{"w", filled({3, 2, 3, 3})}}, {{"strides", std::int64_t{1}}})),
              HasSubstr("another type"));
  EXPECT_THAT(fault(one_node("MaxPool", kImage, {}, {{"kernel_shape", Integers{2}}})),
              HasSubstr("rows and columns"));
  EXPECT_THAT(fault(one_node("MaxPool", kImage, {},
                             {{"kernel_shape", Integers{2, 2}}, {"pads", Integers{2, 0, 0, 0}}})),
              HasSubstr("padded"));
  EXPECT_THAT(fault(one_node("Reshape", kImage, {{"s", integer_list({5, -1})}})),
              HasSubstr("numbers for 96"));
  EXPECT_THAT(fault(one_node("Reshape", kImage, {{"s", integer_list({-1, -1})}})), HasSubstr("open"));
  EXPECT_THAT(fault(one_node("Reshape", kImage, {{"s", integer_list(Integers(9, 1))}})), HasSubstr("96"));
  EXPECT_THAT(fault(one_node("Transpose", kImage, {}, {{"perm", Integers{0, 1, 2, 2}}})), HasSubstr("twice"));
  EXPECT_THAT(fault(one_node("Concat", kImage, {{"c", filled({1, 2, 6, 7})}}, {{"axis", std::int64_t{1}}})),
              HasSubstr("another shape"));
  EXPECT_THAT(fault(one_node("Concat", kImage, {}, {{"axis", std::int64_t{4}}})), HasSubstr("axis 4"));
  EXPECT_THAT(fault(one_node("Slice", kImage,
                             {{"s", integer_list({5})}, {"e", integer_list({2})}, {"a", integer_list({2})}})),
              HasSubstr("size of"));
  EXPECT_THAT(fault(one_node("Softmax", kImage, {}, {{"axis", std::int64_t{-5}}})), HasSubstr("axis -5"));
  EXPECT_THAT(fault(one_node(
                  "BatchNormalization", kImage,
                  {{"s", filled({2})}, {"b", filled({2})}, {"m", filled({2})}, {"v", filled({2}, -1.0f)}})),
              HasSubstr("variance"));
  EXPECT_THAT(fault(one_node("Relu", {1, 2, 6})), HasSubstr("3 sizes"));
  EXPECT_THAT(fault(one_node("Clip", kImage, {{"l", filled({}, 2.0f)}, {"h", filled({}, 1.0f)}})),
              HasSubstr("it clips to [2, 1]"));
  EXPECT_THAT(
      fault(one_node("Conv", kImage, {{"w", filled({3, 2, 3, 3})}}, {{"strides", Integers{1, 1, 1}}})),
      HasSubstr("strides has 3 numbers, expected 2"));
  EXPECT_THAT(fault(one_node("MaxPool", kImage, {},
                             {{"kernel_shape", Integers{2, 2}}, {"auto_pad", std::string("SOME")}})),
              HasSubstr("auto_pad is 'SOME'"));
  EXPECT_THAT(fault(one_node("MaxPool", kImage, {},
                             {{"kernel_shape", Integers{2, 2}},
                              {"auto_pad", std::string("SAME_UPPER")},
                              {"pads", Integers{1, 0, 0, 0}}})),
              HasSubstr("both pads and auto_pad"));
  EXPECT_THAT(fault(one_node("MaxPool", kImage, {}, {{"kernel_shape", Integers{1 << 20, 2}}})),
              HasSubstr("kernel_shape has"));
  EXPECT_THAT(fault(one_node("Relu", kImage, {{"c", filled({1})}})), HasSubstr("2 inputs, expected 1 to 1"));
  OnnxModel two = one_node("Relu", kImage);
  two.inputs.push_back({"x2", kImage});
  EXPECT_THAT(fault(two), HasSubstr("2 inputs"));
}

/// The model with its input first brought into another shape.
OnnxModel of_shape(const Integers& shape, OnnxModel model) {
  for (std::string& input : model.nodes.front().inputs) input = input == "x" ? "shaped" : input;
  model.constants["shape"] = integer_list(shape);
  model.nodes.insert(model.nodes.begin(), {"Reshape", "before", {"x", "shape"}, {"shaped"}});
  return model;
}

/// The model with other names of its node's inputs.
OnnxModel with_inputs(std::vector<std::string> inputs, OnnxModel model) {
  model.nodes.front().inputs = std::move(inputs);
  return model;
}

using Misfits = std::vector<std::pair<OnnxModel, std::string>>;

void expect_refused(const Misfits& misfits) {
  for (const auto& [model, words] : misfits) {
    EXPECT_THAT(fault(model), AllOf(HasSubstr("net.onnx"), HasSubstr(words))) << model.nodes.back().operation;
  }
}

TEST(OnnxCheck, NumbersOfOneInputThatDoNotFitAnotherAreSaid) {
  const auto norm = [](std::int64_t scales) {
    return one_node("BatchNormalization", kImage,
                    {{"s", filled({scales})}, {"b", filled({2})}, {"m", filled({2})}, {"v", filled({2})}});
  };
  expect_refused({
      {norm(3), "input 1 has 3 numbers, expected one per channel (2)"},
      {of_shape({96}, norm(2)), "its input has 1 sizes, expected channels at least"},
      {one_node("PRelu", kImage, {{"slope", filled({3})}}),
       "it has 3 slopes, expected one, or one per channel"},
      {one_node("Clip", kImage, {{"l", filled({2})}}), "min has 2 numbers, expected one"},
      {of_shape({2, 48}, one_node("Gemm", kImage, {{"w", filled({48, 3})}, {"b", filled({2})}})),
       "its bias has 2 numbers, expected 3"},
      {of_shape({2, 48}, one_node("Gemm", kImage, {{"w", filled({47, 3})}})),
       "matrices of 2 x 48 and 47 x 3"},
      {one_node("MatMul", kImage, {{"w", filled({8})}}), "inputs of 4 and 1 sizes"},
      {one_node("MatMul", kImage, {{"w", filled({1, 3, 8, 2})}}), "batches of 2 and 3 matrices"},
      {one_node("MatMul", kImage, {{"w", filled({7, 2})}}), "8 columns times 7 rows"},
  });
}

TEST(OnnxCheck, ShapesThatCannotBeMadeAreSaid) {
  const Integers eight(8, 0);
  expect_refused({
      {one_node("Reshape", kImage, {{"s", integer_list({1, 2, 6, 8, 0})}}), "it keeps size 4 of 4"},
      {one_node("Reshape", kImage, {{"s", integer_list({200, -1})}}), "a size of 200 for 96 numbers"},
      {one_node("Reshape", kImage, {{"s", integer_list({96, 96})}}),
       "a shape of more than 96 numbers for 96"},
      {one_node("Squeeze", kImage, {{"a", integer_list({1})}}), "it takes away a size of 2"},
      {one_node("Unsqueeze", kImage, {{"a", integer_list({})}}), "it adds 0 sizes"},
      {with_inputs({"c", "x"}, one_node("Concat", kImage, {{"c", filled({})}}, {{"axis", std::int64_t{0}}})),
       "it joins single numbers"},
      {one_node("Concat", kImage), "it has no axis"},
      {one_node("Slice", kImage,
                {{"s", integer_list({0, 0})}, {"e", integer_list({1})}, {"a", integer_list({0, 1})}}),
       "starts, ends and axes differ in number"},
      {one_node("Slice", kImage,
                {{"s", integer_list({0})},
                 {"e", integer_list({2})},
                 {"a", integer_list({2})},
                 {"t", integer_list({2})}}),
       "it takes steps other than 1"},
      {one_node("Pad", kImage, {{"p", integer_list(eight)}}, {{"mode", std::string("edge")}}),
       "the mode 'edge', expected constant or reflect"},
      {one_node("Pad", kImage, {{"p", integer_list({1, 1, 1, 1})}}), "4 pads, expected 8"},
      {one_node("Pad", kImage, {{"p", integer_list(eight)}, {"v", filled({2})}}), "it pads with 2 values"},
      {one_node("Pad", kImage, {{"p", integer_list({0, 0, 0, -1, 0, 0, 0, 0})}}), "it pads by -1"},
      {of_opset(12, one_node("ReduceMean", kImage, {}, {{"keepdims", std::int64_t{0}}})),
       "a tensor it makes has 0 sizes"},
      {one_node("ReduceSum", kImage, {}, {{"noop_with_empty_axes", std::int64_t{1}}}),
       "noop_with_empty_axes is not read"},
  });
}

TEST(OnnxCheck, WindowsAndScalesThatCannotBeAreSaid) {
  const OnnxTensor weights = filled({2, 2, 3, 3});
  const auto resize = [](std::vector<float> scales, const std::string& mode) {
    const auto count = static_cast<std::int64_t>(scales.size());
    return one_node("Resize", kImage, {{"r", filled({0})}, {"s", real_tensor({count}, std::move(scales))}},
                    {{"mode", mode}});
  };
  OnnxModel sizes =
      one_node("Resize", kImage, {{"r", filled({0})}, {"s", filled({0})}, {"z", integer_list({6, 8})}});
  expect_refused({
      {one_node("Conv", kImage, {{"w", filled({0, 2, 3, 3})}}), "it has no weights"},
      {one_node("Conv", kImage, {{"w", weights}}, {{"kernel_shape", Integers{2, 2}}}),
       "kernel_shape is not that of its weights"},
      {one_node("Conv", kImage, {{"w", filled({1, 2, 1, 5000})}}), "a kernel of 5000 pixels"},
      {one_node("ConvTranspose", kImage, {{"w", weights}}, {{"auto_pad", std::string("SAME_UPPER")}}),
       "auto_pad is not read here"},
      {one_node("ConvTranspose", kImage, {{"w", weights}}, {{"output_padding", Integers{1, 1}}}),
       "output_padding reaches the stride"},
      {one_node("MaxPool", kImage, {}, {{"kernel_shape", Integers{2, 2}}, {"dilations", Integers{2, 2}}}),
       "its kernel is dilated"},
      {resize({1, 1, 2, 2}, "cubic"), "the mode 'cubic'"},
      {resize({1, 2, 2}, "nearest"), "3 scales, expected 4"},
      {resize({1, 1, 0, 2}, "nearest"), "it scales by 0, expected above 0, at most 64"},
      {resize({1, 1, 65, 2}, "nearest"), "it scales by 65"},
      {resize({1, 2, 1, 1}, "nearest"), "it scales channels, expected rows and columns"},
      {sizes, "2 sizes, expected 4"},
  });
}

TEST(OnnxCheck, NodesHaveTheInputsOutputsAndNamesThatTheyNeed) {
  OnnxModel two_outputs = one_node("Relu", kImage);
  two_outputs.nodes.front().outputs = {"y", "z"};
  OnnxModel no_output = one_node("Relu", kImage);
  no_output.nodes.front().outputs = {""};
  OnnxModel nameless = one_node("Relu", kImage);
  nameless.inputs.front().name.clear();
  OnnxModel twice = one_node("Relu", kImage);
  twice.outputs.push_back(twice.outputs.front());
  OnnxModel ours = one_node("Reshape", kImage, {{"s", integer_list({96})}});
  ours.constants["knuckle:shape:y"] = integer_list({96});
  const auto constant = [](std::map<std::string, OnnxAttribute> attributes) {
    OnnxModel model = one_node("Relu", kImage);
    model.nodes.insert(model.nodes.begin(), {"Constant", "c", {}, {"c"}, std::move(attributes)});
    return model;
  };
  expect_refused({
      {two_outputs, "2 outputs, expected one"},
      {no_output, "it has no output"},
      {nameless, "a tensor without a name"},
      {twice, "the output 'y' is there twice"},
      {ours, "'knuckle:shape:y' is a name of ours"},
      {with_inputs({"x", "", "c"},
                   one_node("Concat", kImage, {{"c", filled({1, 2, 6, 8})}}, {{"axis", std::int64_t{1}}})),
       "input 1 is missing"},
      {with_inputs({"x", "", "b"}, one_node("Conv", kImage, {{"b", filled({3})}})), "input 1 is missing"},
      {one_node("Conv", kImage, {{"w", integer_list({1, 2, 3})}}), "input 1 is not of real numbers"},
      {one_node("Reshape", kImage, {{"s", filled({2})}}), "input 1 is not of whole numbers"},
      {constant({}), "expected one value and one output"},
      {constant({{"value_float", 1.0f}}), "the attribute 'value_float', expected a tensor 'value'"},
  });
}

TEST(OnnxCheck, ConstantsAreFinite) {
  const float infinite = std::numeric_limits<float>::infinity();
  EXPECT_THAT(fault(one_node("Add", kImage, {{"c", filled({1}, infinite)}})),
              HasSubstr("'c' holds a number"));
  EXPECT_THAT(fault(one_node("LeakyRelu", kImage, {}, {{"alpha", infinite}})),
              HasSubstr("'alpha' is not finite"));
}

TEST(OnnxCheck, ShapesAreNotMadeOfWholeNumbersThatAreComputed) {
  OnnxModel model = one_node("Reshape", kImage);
  model.nodes.front().inputs = {"x", "x"};
  EXPECT_THAT(fault(model), HasSubstr("no constant"));
  EXPECT_THAT(fault(one_node("Add", kImage, {{"c", integer_list({1})}})), HasSubstr("whole numbers"));
}

/// A few bytes that ask for more and more memory.
TEST(OnnxCheck, MemoryIsBounded) {
  OnnxModel doubling = one_node("Concat", {1, 1, 16, 16});
  doubling.nodes.clear();
  std::string last = "x";
  for (int i = 0; i < 60; ++i) {
    const std::string next = fmt::format("t{}", i);
    doubling.nodes.push_back({"Concat", next, {last, last}, {next}, {{"axis", std::int64_t{1}}}});
    last = next;
  }
  doubling.outputs = {{last, {}}};
  EXPECT_THAT(fault(doubling), HasSubstr("MB, expected at most 1024 MB"));

  const OnnxTensor scales = real_tensor({4}, {1, 1, 64, 64});
  EXPECT_THAT(fault(one_node("Resize", {1, 1, 4096, 4096}, {{"", {}}, {"s", scales}})),
              HasSubstr("too many"));
  EXPECT_THAT(
      fault(one_node("Resize", kImage, {{"", {}}, {"", {}}, {"s", integer_list({1, 2, 1 << 30, 1 << 30})}})),
      HasSubstr("too many"));
  EXPECT_THAT(fault(one_node("Pad", kImage, {{"p", integer_list({0, 0, 0, 0, 0, 0, 1LL << 40, 0})}})),
              HasSubstr("pads by"));
  EXPECT_THAT(fault(one_node("ConvTranspose", {1, 1, 4096, 4096}, {{"w", filled({1, 1, 1, 1})}},
                             {{"strides", Integers{4096, 4096}}})),
              HasSubstr("too many"));
  EXPECT_THAT(fault(one_node("Relu", {1, 16384, 16384, 16384})), HasSubstr("MB"));
  EXPECT_THAT(fault(one_node("Relu", kImage), {.numbers = 100}), HasSubstr("expected at most"));
}

TEST(OnnxCheck, WorkIsBounded) {
  const OnnxModel wide = one_node("Conv", {1, 64, 1024, 1024}, {{"w", filled({64, 64, 11, 11})}});
  EXPECT_THAT(fault(wide), HasSubstr("multiplications"));
  const OnnxModel small = one_node("Conv", kImage, {{"w", filled({3, 2, 3, 3})}});
  EXPECT_THAT(fault(small, {.work = 3 * 4 * 6 * 2 * 9 - 1}), HasSubstr("multiplications"));
  EXPECT_NO_THROW((void)checked_onnx(small, "n", {.work = 3 * 4 * 6 * 2 * 9}));
}

}  // namespace
}  // namespace knuckle
