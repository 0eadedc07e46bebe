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
  OnnxModel two = one_node("Relu", kImage);
  two.inputs.push_back({"x2", kImage});
  EXPECT_THAT(fault(two), HasSubstr("2 inputs"));
}

/// The model with an operation before its node, which changes the shape of what that reads.
OnnxModel after_reshape(OnnxShape shape, OnnxModel model) {
  model.nodes.front().inputs.front() = "reshaped";
  model.constants["shape"] = integer_list(std::move(shape));
  model.nodes.insert(model.nodes.begin(), {"Reshape", "first", {"x", "shape"}, {"reshaped"}});
  return model;
}

TEST(OnnxCheck, ANodeHasAllItsInputsAndOneOutput) {
  EXPECT_THAT(fault(one_node("Add", kImage)), HasSubstr("1 inputs, expected 2 to 2"));
  EXPECT_THAT(fault(one_node("Relu", kImage, {{"c", filled({1})}})), HasSubstr("2 inputs, expected 1 to 1"));
  EXPECT_THAT(fault(one_node("BatchNormalization", kImage,
                             {{"s", filled({2})}, {"", {}}, {"m", filled({2})}, {"v", filled({2})}})),
              HasSubstr("input 2 is missing"));
  OnnxModel model = one_node("Add", kImage, {{"c", filled({1})}});
  model.nodes.front().inputs = {"", "x"};
  EXPECT_THAT(fault(model), HasSubstr("input 0 is missing"));

  model = one_node("Relu", kImage);
  model.nodes.front().outputs = {};
  EXPECT_THAT(fault(model), HasSubstr("(Relu): it has no output"));
  model.nodes.front().outputs = {"", "y"};
  EXPECT_THAT(fault(model), HasSubstr("(Relu): it has no output"));
  model.nodes.front().outputs = {"y", "z"};
  EXPECT_THAT(fault(model), HasSubstr("2 outputs, expected one"));
  model = one_node("Relu", kImage);
  model.outputs = {};
  EXPECT_THAT(fault(model), HasSubstr("net.onnx: it has no output"));
  model.outputs = {{"y", {}}, {"y", {}}};
  EXPECT_THAT(fault(model), HasSubstr("the output 'y' is there twice"));
}

TEST(OnnxCheck, AConstantNodeHoldsOneNewTensor) {
  const auto with_constant = [](std::vector<std::string> outputs,
                                std::map<std::string, OnnxAttribute> attributes) {
    OnnxModel model = one_node("Add", kImage);
    model.nodes.front().inputs = {"x", "c"};
    model.nodes.insert(model.nodes.begin(),
                       {"Constant", "constant", {}, std::move(outputs), std::move(attributes)});
    return model;
  };
  EXPECT_NO_THROW((void)checked_onnx(with_constant({"c"}, {{"value", filled({1})}}), "n"));
  EXPECT_THAT(fault(with_constant({"c", "d"}, {{"value", filled({1})}})),
              HasSubstr("one value and one output"));
  EXPECT_THAT(fault(with_constant({"c"}, {})), HasSubstr("expected one value and one output"));
  EXPECT_THAT(fault(with_constant({"c"}, {{"value_float", 1.0f}})),
              HasSubstr("the attribute 'value_float', expected a tensor 'value'"));
  EXPECT_THAT(fault(with_constant({"x"}, {{"value", filled({1})}})),
              HasSubstr("makes 'x', which is there already"));
  EXPECT_THAT(fault(with_constant({""}, {{"value", filled({1})}})), HasSubstr("a tensor without a name"));
  EXPECT_THAT(fault(with_constant({"c"}, {{"value", filled({1}, std::numeric_limits<float>::quiet_NaN())}})),
              HasSubstr("(Constant) holds a number that is not finite"));
}

/// What the check adds itself has names that a file could have taken.
TEST(OnnxCheck, TheNamesThatTheCheckGivesAreNotTaken) {
  OnnxModel flatten = one_node("Flatten", kImage);
  flatten.constants["knuckle:shape:y"] = integer_list({1, 96});
  EXPECT_THAT(fault(flatten), HasSubstr("'knuckle:shape:y' is a name of ours"));
  flatten = one_node("Flatten", kImage);
  flatten.nodes.insert(flatten.nodes.begin(), {"Relu", "first", {"x"}, {"knuckle:shape:y"}});
  EXPECT_THAT(fault(flatten), HasSubstr("'knuckle:shape:y' is a name of ours"));

  OnnxModel concat = one_node("Concat", kImage, {{"c", filled({1, 3, 6, 8})}}, {{"axis", std::int64_t{1}}});
  concat.constants["knuckle:one"] = filled({1}, 2.0f);
  EXPECT_THAT(fault(concat), HasSubstr("makes 'knuckle:one', which is there already"));
  concat.constants.erase("knuckle:one");
  concat.constants["knuckle:copy:x"] = filled({1}, 2.0f);
  EXPECT_THAT(fault(concat), HasSubstr("makes 'knuckle:copy:x', which is there already"));
}

/// A tensor without numbers would be stretched to the other's size, and read.
TEST(OnnxCheck, NothingIsComputedWithTensorsWithoutNumbers) {
  EXPECT_THAT(fault(one_node("Add", {1, 1, 1, 1}, {{"c", filled({0})}})),
              HasSubstr("input 1 is a constant without numbers"));
  EXPECT_THAT(fault(one_node("Concat", kImage, {{"c", filled({1, 0, 6, 8})}}, {{"axis", std::int64_t{1}}})),
              HasSubstr("input 1 is a constant without numbers"));
  EXPECT_THAT(fault(one_node("Conv", kImage, {{"w", filled({0, 2, 3, 3})}})),
              HasSubstr("input 1 is a constant without numbers"));
}

TEST(OnnxCheck, InputsAreOfTheExpectedKind) {
  EXPECT_THAT(fault(one_node("Reshape", kImage, {{"s", filled({2})}})),
              HasSubstr("input 1 is not of whole numbers"));
  EXPECT_THAT(fault(one_node("Conv", kImage, {{"w", integer_list({1})}})),
              HasSubstr("input 1 is not of real numbers"));
  EXPECT_THAT(fault(after_reshape({96}, one_node("GlobalMaxPool", kImage))),
              HasSubstr("input 0 has 1 sizes, expected 4"));
  EXPECT_THAT(
      fault(after_reshape(
          {96}, one_node("BatchNormalization", kImage,
                         {{"s", filled({2})}, {"b", filled({2})}, {"m", filled({2})}, {"v", filled({2})}}))),
      HasSubstr("its input has 1 sizes, expected channels at least"));
}

TEST(OnnxCheck, OperatorsOnNumbersGetAsManyAsTheyNeed) {
  EXPECT_THAT(fault(one_node("Clip", kImage, {{"low", filled({}, 2.0f)}, {"high", filled({}, 1.0f)}})),
              HasSubstr("it clips to [2, 1]"));
  EXPECT_THAT(fault(one_node("Clip", kImage, {{"low", filled({2})}})),
              HasSubstr("min has 2 numbers, expected one"));
  EXPECT_THAT(fault(one_node("PRelu", kImage, {{"slope", filled({3})}})),
              HasSubstr("it has 3 slopes, expected one, or one per channel"));
  EXPECT_THAT(fault(after_reshape({96}, one_node("PRelu", kImage, {{"slope", filled({96})}}))),
              HasSubstr("it has 96 slopes"));
  EXPECT_THAT(
      fault(one_node("BatchNormalization", kImage,
                     {{"s", filled({2})}, {"b", filled({3})}, {"m", filled({2})}, {"v", filled({2})}})),
      HasSubstr("input 2 has 3 numbers, expected one per channel (2)"));
  EXPECT_THAT(
      fault(one_node("BatchNormalization", kImage,
                     {{"s", filled({2})}, {"b", filled({2})}, {"m", filled({2})}, {"v", filled({2}, 1.0f)}},
                     {{"epsilon", 0.0f}})),
      HasSubstr("epsilon is not above 0"));
}

TEST(OnnxCheck, AnOldSoftmaxIsOfTheLastAxis) {
  const auto softmax = [](std::int64_t opset, std::int64_t axis) {
    return testing::of_opset(opset, one_node("Softmax", kImage, {}, {{"axis", axis}}));
  };
  EXPECT_NO_THROW((void)checked_onnx(softmax(13, 1), "n"));
  EXPECT_NO_THROW((void)checked_onnx(softmax(12, 3), "n"));
  EXPECT_THAT(fault(softmax(12, 1)), HasSubstr("before opset 13 it takes the axes from 1 on together"));
}

TEST(OnnxCheck, OperatorsOnShapesNameEachAxisOnceAndKeepAllNumbers) {
  EXPECT_THAT(fault(one_node("Reshape", kImage, {{"s", integer_list({1, 2, 6, 8, 0})}})),
              HasSubstr("it keeps size 4 of 4"));
  EXPECT_THAT(fault(one_node("Reshape", kImage, {{"s", integer_list({-2, -1})}})),
              HasSubstr("a size of -2 for 96 numbers"));
  EXPECT_THAT(fault(one_node("Reshape", kImage, {{"s", integer_list({96, 96})}})),
              HasSubstr("a shape of more than 96 numbers for 96"));
  EXPECT_THAT(fault(one_node("Reshape", kImage, {{"s", integer_list({5, 6})}})),
              HasSubstr("a shape of 30 numbers for 96"));
  EXPECT_THAT(
      fault(one_node("Reshape", kImage, {{"s", integer_list({96})}}, {{"allowzero", std::int64_t{1}}})),
      HasSubstr("allowzero is 1, expected 0 to 0"));
  EXPECT_THAT(fault(one_node("Squeeze", kImage, {{"a", integer_list({0, -4})}})),
              HasSubstr("it names an axis twice"));
  EXPECT_THAT(fault(one_node("Squeeze", kImage, {{"a", integer_list({1})}})),
              HasSubstr("it takes away a size of 2"));
  EXPECT_THAT(fault(one_node("Squeeze", {1, 1, 1, 1})), HasSubstr("has 0 sizes, expected 1 to 8"));
  EXPECT_THAT(fault(one_node("Unsqueeze", kImage, {{"a", integer_list({0, 1, 2, 3, 4})}})),
              HasSubstr("it adds 5 sizes"));
  EXPECT_THAT(fault(one_node("Unsqueeze", kImage, {{"a", integer_list({})}})), HasSubstr("it adds 0 sizes"));
  EXPECT_THAT(fault(one_node("Transpose", kImage, {}, {{"perm", Integers{1, 0}}})),
              HasSubstr("perm has 2 numbers, expected 4"));
  EXPECT_THAT(fault(one_node("ReduceSum", kImage, {}, {{"noop_with_empty_axes", std::int64_t{1}}})),
              HasSubstr("noop_with_empty_axes is not read"));
  EXPECT_THAT(fault(one_node("ReduceSum", kImage, {{"a", integer_list({2, 2})}})),
              HasSubstr("it names an axis twice"));
}

TEST(OnnxCheck, OperatorsThatJoinCutAndPadSayForWhichAxes) {
  EXPECT_THAT(fault(one_node("Concat", kImage, {{"c", filled(kImage)}})), HasSubstr("it has no axis"));
  OnnxModel numbers = one_node("Concat", kImage, {{"c", filled({})}}, {{"axis", std::int64_t{0}}});
  std::ranges::reverse(numbers.nodes.front().inputs);
  EXPECT_THAT(fault(numbers), HasSubstr("it joins single numbers"));

  const auto slice = [](Integers axes, Integers ends, std::vector<std::pair<std::string, OnnxTensor>> more) {
    std::vector<std::pair<std::string, OnnxTensor>> inputs = {
        {"s", integer_list({0})}, {"e", integer_list(std::move(ends))}, {"a", integer_list(std::move(axes))}};
    inputs.insert(inputs.end(), more.begin(), more.end());
    return one_node("Slice", kImage, std::move(inputs));
  };
  EXPECT_NO_THROW((void)checked_onnx(slice({2}, {2}, {}), "n"));
  EXPECT_THAT(fault(slice({2}, {2, 2}, {})), HasSubstr("starts, ends and axes differ in number"));
  EXPECT_THAT(fault(slice({2, 3}, {2}, {})), HasSubstr("starts, ends and axes differ in number"));
  EXPECT_THAT(fault(slice({2}, {2}, {{"t", integer_list({2})}})), HasSubstr("it takes steps other than 1"));

  const OnnxTensor pads = integer_list({0, 0, 1, 2, 0, 0, 3, 4});
  EXPECT_THAT(fault(one_node("Pad", kImage, {{"p", pads}}, {{"mode", std::string("edge")}})),
              HasSubstr("the mode 'edge', expected constant or reflect"));
  EXPECT_THAT(fault(one_node("Pad", kImage, {{"p", integer_list({1, 1, 1, 1})}})),
              HasSubstr("4 pads, expected 8"));
  EXPECT_THAT(fault(one_node("Pad", kImage, {{"p", pads}, {"v", filled({2})}})),
              HasSubstr("it pads with 2 values"));
  EXPECT_THAT(fault(one_node("Pad", kImage, {{"p", integer_list({0, 0, 6, 0, 0, 0, 0, 0})}},
                             {{"mode", std::string("reflect")}})),
              HasSubstr("it pads by 6, expected 0 to 5"));
}

TEST(OnnxCheck, OperatorsOnWindowsFitTheirImage) {
  const auto convolution = [](OnnxShape weights, std::map<std::string, OnnxAttribute> attributes) {
    return fault(one_node("Conv", kImage, {{"w", filled(std::move(weights))}}, std::move(attributes)));
  };
  EXPECT_THAT(convolution({3, 2, 3}, {}), HasSubstr("input 1 has 3 sizes, expected 4"));
  EXPECT_THAT(convolution({3, 2, 3, 3}, {{"kernel_shape", Integers{3, 2}}}),
              HasSubstr("kernel_shape is not that of its weights"));
  EXPECT_THAT(convolution({1, 2, 4097, 1}, {}), HasSubstr("a kernel of 4097 pixels"));
  EXPECT_THAT(convolution({3, 2, 3, 3}, {{"strides", Integers{1, 1, 1}}}),
              HasSubstr("strides has 3 numbers, expected 2"));
  EXPECT_THAT(convolution({3, 2, 3, 3}, {{"auto_pad", std::string("SAME")}}),
              HasSubstr("auto_pad is 'SAME'"));
  EXPECT_THAT(convolution({3, 2, 1, 2}, {{"auto_pad", std::string("SAME_LOWER")}}),
              HasSubstr("SAME_LOWER with an odd padding of 1 is not read"));
  EXPECT_NO_THROW((void)checked_onnx(
      one_node("Conv", kImage, {{"w", filled({3, 2, 3, 3})}}, {{"auto_pad", std::string("SAME_LOWER")}}),
      "n"));
  EXPECT_THAT(
      convolution({3, 2, 3, 3}, {{"auto_pad", std::string("SAME_UPPER")}, {"pads", Integers{1, 1, 1, 1}}}),
      HasSubstr("it has both pads and auto_pad"));

  const auto transposed = [](OnnxShape weights, std::map<std::string, OnnxAttribute> attributes) {
    return fault(
        one_node("ConvTranspose", kImage, {{"w", filled(std::move(weights))}}, std::move(attributes)));
  };
  EXPECT_THAT(transposed({3, 2, 4, 4}, {}), HasSubstr("weights are for 3 channels, its input has 2"));
  EXPECT_THAT(transposed({2, 3, 4, 4}, {{"auto_pad", std::string("SAME_UPPER")}}),
              HasSubstr("auto_pad is not read here"));
  EXPECT_THAT(transposed({2, 3, 4, 4}, {{"strides", Integers{2, 2}}, {"output_padding", Integers{0, 2}}}),
              HasSubstr("output_padding reaches the stride"));
  EXPECT_THAT(transposed({2, 3, 2, 2}, {{"pads", Integers{4, 0, 4, 0}}}), HasSubstr("has a size of -1"));
  EXPECT_THAT(fault(one_node("ConvTranspose", kImage, {{"w", filled({2, 3, 4, 4})}, {"b", filled({2})}})),
              HasSubstr("its bias has 2 numbers, expected 3"));

  const auto pool = [](std::map<std::string, OnnxAttribute> attributes) {
    attributes["kernel_shape"] = Integers{3, 3};
    return fault(one_node("MaxPool", kImage, {}, std::move(attributes)));
  };
  EXPECT_THAT(pool({{"pads", Integers{0, 0, 0, 3}}}), HasSubstr("it is padded by its whole kernel"));
  EXPECT_THAT(pool({{"dilations", Integers{1, 2}}}), HasSubstr("its kernel is dilated"));
  const auto average = [](Integers pads) {
    return one_node("AveragePool", kImage, {},
                    {{"kernel_shape", Integers{3, 3}},
                     {"pads", std::move(pads)},
                     {"count_include_pad", std::int64_t{1}}});
  };
  EXPECT_NO_THROW((void)checked_onnx(average({0, 0, 0, 0}), "n"));
  EXPECT_THAT(fault(average({0, 1, 0, 1})), HasSubstr("count_include_pad is 1, which is not read"));
}

TEST(OnnxCheck, AnImageIsScaledInRowsAndColumns) {
  const auto scaled = [](std::vector<float> scales) {
    const auto count = static_cast<std::int64_t>(scales.size());
    return one_node("Resize", kImage, {{"", {}}, {"s", real_tensor({count}, std::move(scales))}});
  };
  EXPECT_NO_THROW((void)checked_onnx(scaled({1, 1, 2, 2}), "n"));
  EXPECT_THAT(fault(scaled({1, 1, 2})), HasSubstr("3 scales, expected 4"));
  EXPECT_THAT(fault(scaled({1, 2, 2, 2})), HasSubstr("it scales channels, expected rows and columns"));
  EXPECT_THAT(fault(scaled({1, 1, 0, 2})), HasSubstr("it scales by 0, expected above 0, at most 64"));
  EXPECT_THAT(fault(scaled({1, 1, 2, 65})), HasSubstr("it scales by 65, expected above 0, at most 64"));
  EXPECT_THAT(fault(one_node("Resize", kImage, {{"", {}}, {"", {}}, {"s", integer_list({12, 16})}})),
              HasSubstr("2 sizes, expected 4"));
  EXPECT_THAT(fault(one_node("Resize", kImage, {{"", {}}, {"s", real_tensor({4}, {1, 1, 2, 2})}},
                             {{"mode", std::string("cubic")}})),
              HasSubstr("the mode 'cubic'"));
}

TEST(OnnxCheck, MatricesFitTogether) {
  const auto gemm = [](OnnxTensor weights, OnnxTensor bias) {
    return after_reshape({1, 96},
                         one_node("Gemm", kImage, {{"w", std::move(weights)}, {"b", std::move(bias)}}));
  };
  EXPECT_NO_THROW((void)checked_onnx(gemm(filled({96, 4}), filled({4})), "n"));
  EXPECT_THAT(fault(gemm(filled({95, 4}), filled({4}))), HasSubstr("matrices of 1 x 96 and 95 x 4"));
  EXPECT_THAT(fault(gemm(filled({96, 4}), filled({3}))), HasSubstr("its bias has 3 numbers, expected 4"));
  const auto gemm_with = [&](const std::string& name, OnnxAttribute value) {
    OnnxModel model = gemm(filled({96, 4}), filled({4}));
    model.nodes.back().attributes[name] = std::move(value);
    return model;
  };
  EXPECT_NO_THROW((void)checked_onnx(gemm_with("alpha", 1.0f), "n"));
  EXPECT_THAT(fault(gemm_with("alpha", 2.0f)), HasSubstr("alpha is 2, expected 1"));
  EXPECT_THAT(fault(gemm_with("beta", 0.5f)), HasSubstr("beta is 0.5, expected 1"));
  EXPECT_THAT(fault(gemm_with("transA", std::int64_t{1})), HasSubstr("transA is 1, expected 0 to 0"));
  const auto product = [](OnnxTensor matrices) {
    return one_node("MatMul", kImage, {{"w", std::move(matrices)}});
  };
  EXPECT_NO_THROW((void)checked_onnx(product(filled({1, 2, 8, 3})), "n"));
  EXPECT_THAT(fault(product(filled({8}))), HasSubstr("inputs of 4 and 1 sizes"));
  EXPECT_THAT(fault(product(filled({2, 8, 3}))), HasSubstr("inputs of 4 and 3 sizes"));
  EXPECT_THAT(fault(product(filled({1, 3, 8, 3}))), HasSubstr("batches of 2 and 3 matrices"));
  EXPECT_THAT(fault(product(filled({7, 3}))), HasSubstr("8 columns times 7 rows"));
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
