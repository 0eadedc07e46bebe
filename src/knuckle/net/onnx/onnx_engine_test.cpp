// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx/onnx_engine.h"

#include <cmath>
#include <numeric>

#include "knuckle/core/testing.h"
#include "knuckle/net/onnx/onnx_check.h"
#include "knuckle/net/onnx/onnx_testing.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using testing::error_of;
using testing::filled;
using ::testing::FloatNear;
using ::testing::HasSubstr;
using testing::one_node;

class OnnxEngineTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
  }

  static std::vector<float> run(const OnnxModel& model) {
    const OnnxModel checked = checked_onnx(model, "net.onnx");
    std::vector<float> input(static_cast<std::size_t>(count_of(checked.inputs.front().shape)));
    std::iota(input.begin(), input.end(), 0.0f);
    return create_onnx_engine(checked, "net.onnx")->run(input).front();
  }
};

TEST_F(OnnxEngineTest, RunsEveryOperatorOfTheList) {
  for (const testing::OperatorCase& known : testing::operator_cases()) {
    SCOPED_TRACE(known.model.nodes.back().operation);
    try {
      EXPECT_EQ(static_cast<std::int64_t>(run(known.model).size()), count_of(known.output));
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
  }
}

TEST_F(OnnxEngineTest, ComputesWhatTheOperatorsSay) {
  const OnnxShape four = {1, 1, 2, 2};  // 0 1 / 2 3
  EXPECT_THAT(run(one_node("Mul", four, {{"c", filled({1}, -2.0f)}})), ElementsAre(0, -2, -4, -6));
  EXPECT_THAT(run(one_node("Clip", four, {{"l", filled({}, 1.0f)}, {"h", filled({}, 2.0f)}})),
              ElementsAre(1, 1, 2, 2));
  EXPECT_THAT(
      run(one_node("Conv", four, {{"w", real_tensor({1, 1, 1, 2}, {1, 10})}, {"b", filled({1}, 0.5f)}})),
      ElementsAre(10.5f, 32.5f));
  EXPECT_THAT(run(one_node("Transpose", four, {}, {{"perm", testing::Integers{0, 1, 3, 2}}})),
              ElementsAre(0, 2, 1, 3));
  EXPECT_THAT(run(one_node("MatMul", four, {{"w", real_tensor({2, 1}, {1, 100})}})), ElementsAre(100, 302));
  EXPECT_THAT(run(one_node("ReduceSum", four, {{"a", integer_list({3})}})), ElementsAre(1, 5));
  EXPECT_THAT(run(one_node("ReduceSum", four)), ElementsAre(6));
  EXPECT_THAT(run(one_node("ReduceMean", four)), ElementsAre(1.5f));
  EXPECT_THAT(run(one_node("ReduceMax", four)), ElementsAre(3));
  EXPECT_THAT(run(one_node("MaxPool", four, {}, {{"kernel_shape", testing::Integers{2, 2}}})),
              ElementsAre(3));
  EXPECT_THAT(run(one_node("Pad", four, {{"p", integer_list({0, 0, 0, 1, 0, 0, 0, 0})}})),
              ElementsAre(0, 0, 1, 0, 2, 3));
  EXPECT_THAT(run(one_node("Softmax", {1, 1, 1, 2}, {}, {{"axis", std::int64_t{3}}})),
              ElementsAre(FloatNear(0.268941f, 1e-5f), FloatNear(0.731059f, 1e-5f)));
}

/// A matrix of as many rows as columns: whether it is turned does not show in its shape.
TEST_F(OnnxEngineTest, AMatrixIsTurnedWhereItSaysSo) {
  const auto gemm = [](std::map<std::string, OnnxAttribute> attributes) {
    OnnxModel model = one_node("Flatten", {1, 1, 1, 2});  // 0 1
    model.nodes.front().outputs = {"flat"};
    model.constants = {{"w", real_tensor({2, 2}, {1, 2, 3, 4})}, {"b", filled({2}, 10.0f)}};
    model.nodes.push_back({"Gemm", "gemm", {"flat", "w", "b"}, {"y"}, std::move(attributes)});
    return model;
  };
  EXPECT_THAT(run(gemm({})), ElementsAre(13, 14));
  EXPECT_THAT(run(gemm({{"transB", std::int64_t{0}}})), ElementsAre(13, 14));
  EXPECT_THAT(run(gemm({{"transB", std::int64_t{1}}})), ElementsAre(12, 14));
  EXPECT_THAT(run(one_node("MatMul", {1, 1, 1, 2}, {{"w", real_tensor({2, 2}, {1, 2, 3, 4})}})),
              ElementsAre(3, 4));
}

TEST_F(OnnxEngineTest, ASoftmaxIsOfTheAxisThatItsVersionMeans) {
  const auto near = [](float value) { return FloatNear(value, 1e-5f); };
  EXPECT_THAT(run(one_node("Softmax", {1, 1, 2, 2})),
              ElementsAre(near(0.268941f), near(0.731059f), near(0.268941f), near(0.731059f)));
  EXPECT_THAT(run(testing::of_opset(9, one_node("Softmax", {1, 2, 1, 1}))),
              ElementsAre(near(0.268941f), near(0.731059f)));
}

TEST_F(OnnxEngineTest, PaddingIsWhereItSaysAndIsNotCounted) {
  const OnnxShape four = {1, 1, 2, 2};
  EXPECT_THAT(run(one_node("Conv", four, {{"w", real_tensor({1, 1, 1, 2}, {1, 10})}},
                           {{"auto_pad", std::string("SAME_UPPER")}})),
              ElementsAre(10, 1, 32, 3));
  EXPECT_THAT(
      run(one_node("AveragePool", four, {},
                   {{"kernel_shape", testing::Integers{2, 2}}, {"pads", testing::Integers{1, 1, 0, 0}}})),
      ElementsAre(0, 0.5, 1, 1.5));
}

TEST_F(OnnxEngineTest, TheInputIsJoinedWithConstants) {
  EXPECT_THAT(
      run(one_node("Concat", {1, 1, 1, 2}, {{"c", filled({1, 1, 1, 2}, 7.0f)}}, {{"axis", std::int64_t{1}}})),
      ElementsAre(0, 1, 7, 7));
}

TEST_F(OnnxEngineTest, GivesAllOutputsInTheirOrder) {
  OnnxModel model = one_node("Relu", {1, 1, 1, 2});
  model.nodes.push_back({"Neg", "negative", {"x"}, {"z"}});
  model.outputs = {{"z", {}}, {"y", {}}};
  const OnnxModel checked = checked_onnx(model, "net.onnx");
  const std::vector<float> input = {-1.0f, 2.0f};
  const auto outputs = create_onnx_engine(checked, "net.onnx")->run(input);
  ASSERT_EQ(outputs.size(), 2u);
  EXPECT_THAT(outputs[0], ElementsAre(1.0f, -2.0f));
  EXPECT_THAT(outputs[1], ElementsAre(0.0f, 2.0f));
}

TEST_F(OnnxEngineTest, InputsAndOutputsHaveTheShapesOfTheModel) {
  OnnxModel model = checked_onnx(one_node("Relu", {1, 1, 2, 2}), "net.onnx");
  EXPECT_THAT(create_onnx_engine(model, "net.onnx")->run(std::vector<float>(4, 1.0f)).front(),
              ElementsAre(1.0f, 1.0f, 1.0f, 1.0f));
  const auto fault_of = [&](std::size_t numbers) -> std::string {
    try {
      (void)create_onnx_engine(model, "net.onnx")->run(std::vector<float>(numbers, 1.0f));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no fault";
  };
  EXPECT_THAT(fault_of(5), HasSubstr("an input of another size"));
  model.outputs.front().shape = {1, 1, 2, 3};
  EXPECT_THAT(fault_of(4), HasSubstr("output 'y' has another shape than the file says"));
}

TEST_F(OnnxEngineTest, WhatTheEngineCannotIsOneLine) {
  OnnxModel model = checked_onnx(one_node("Relu", {1, 1, 2, 2}), "net.onnx");
  model.nodes.front().operation = "Teleport";
  const std::string fault = error_of([&] { (void)create_onnx_engine(model, "net.onnx"); });
  EXPECT_THAT(fault, HasSubstr("net.onnx: OpenCV"));
  EXPECT_EQ(fault.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace knuckle
