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
