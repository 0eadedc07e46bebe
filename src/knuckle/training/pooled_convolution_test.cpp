// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/pooled_convolution.h"

#include <string>

#include <gtest/gtest.h>
#include <torch/utils.h>

namespace knuckle {
namespace {

struct PoolCase {
  std::string name;
  int inputs;
  int outputs;
  int height;
  int width;
  PooledConvolutionShape shape;
};

class PooledConvolutions : public ::testing::TestWithParam<PoolCase> {
 protected:
  struct Tensors {
    torch::Tensor maps, weight, bias;
  };

  static Tensors random_tensors(torch::ScalarType type) {
    const PoolCase& c = GetParam();
    torch::manual_seed(5);
    const auto make = [&](torch::IntArrayRef sizes) {
      return torch::randn(sizes).to(type).requires_grad_(true);
    };
    return {make({3, c.inputs, c.height, c.width}),
            make({c.outputs, c.inputs, c.shape.kernel, c.shape.kernel}), make({c.outputs})};
  }

  static torch::Tensor apply(const Tensors& tensors) {
    return pooled_convolution(tensors.maps, tensors.weight, tensors.bias, GetParam().shape);
  }
};

INSTANTIATE_TEST_SUITE_P(, PooledConvolutions,
                         ::testing::Values(PoolCase{"bank5_pool4", 1, 16, 36, 36, {5, 4}},
                                           PoolCase{"bank6_pool2", 16, 32, 12, 12, {6, 2}},
                                           PoolCase{"bank4_no_pool", 1, 16, 12, 12, {4, 1}},
                                           PoolCase{"rest_left_over", 3, 5, 13, 12, {3, 4}},
                                           PoolCase{"one_pixel", 2, 1, 1, 1, {1, 1}},
                                           PoolCase{"wide", 1, 3, 6, 19, {2, 3}}),
                         [](const auto& instance) { return instance.param.name; });

// Double precision takes LibTorch's own operations: the reference.
TEST_P(PooledConvolutions, AreLibTorchsForwardAndBack) {
  const Tensors ours = random_tensors(torch::kFloat);
  const Tensors reference = random_tensors(torch::kDouble);
  const torch::Tensor values = apply(ours);
  const torch::Tensor expected = apply(reference);
  ASSERT_EQ(values.sizes(), expected.sizes());
  EXPECT_TRUE(torch::allclose(values.to(torch::kDouble), expected, 1e-4, 1e-5));
  const torch::Tensor weights = torch::randn(expected.sizes(), torch::kDouble);
  (values * weights.to(torch::kFloat)).sum().backward();
  (expected * weights).sum().backward();
  const auto is_close = [](const torch::Tensor& a, const torch::Tensor& b) {
    return torch::allclose(a.grad().to(torch::kDouble), b.grad(), 1e-3, 1e-4);
  };
  EXPECT_TRUE(is_close(ours.maps, reference.maps));
  EXPECT_TRUE(is_close(ours.weight, reference.weight));
  EXPECT_TRUE(is_close(ours.bias, reference.bias));
}

TEST_P(PooledConvolutions, TakeMapsStoredInAnyOrder) {
  Tensors tensors = random_tensors(torch::kFloat);
  const torch::Tensor expected = apply(tensors);
  tensors.maps = tensors.maps.detach().contiguous(torch::MemoryFormat::ChannelsLast);
  tensors.weight = tensors.weight.detach().contiguous(torch::MemoryFormat::ChannelsLast);
  EXPECT_TRUE(torch::equal(apply(tensors), expected));
}

TEST(PooledConvolution, AsksNoGradientOfPatches) {
  const torch::Tensor patches = torch::rand({2, 1, 8, 8});
  const torch::Tensor weight = torch::rand({4, 1, 3, 3}).requires_grad_(true);
  pooled_convolution(patches, weight, torch::zeros({4}), {3, 2}).sum().backward();
  EXPECT_FALSE(patches.grad().defined());
  EXPECT_GT(weight.grad().abs().min().item<float>(), 0.0f);
}

}  // namespace
}  // namespace knuckle
