// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/kept_weights.h"

#include <gtest/gtest.h>
#include <torch/utils.h>

namespace knuckle {
namespace {

TEST(KeptWeights, AreTheRowsAndColumnsForwardAndBack) {
  const torch::Tensor some_rows = torch::tensor({0, 2, 6}, torch::kLong);
  const torch::Tensor some_columns = torch::tensor({1, 4}, torch::kLong);
  for (const torch::Tensor& rows : {torch::Tensor(), some_rows}) {
    for (const torch::Tensor& columns : {torch::Tensor(), some_columns}) {
      const torch::Tensor weight = torch::randn({7, 5}).requires_grad_(true);
      // Double precision takes LibTorch's own operations: the reference.
      const torch::Tensor reference = weight.detach().to(torch::kDouble).requires_grad_(true);
      const torch::Tensor part = kept_weights(weight, rows, columns);
      const torch::Tensor expected = kept_weights(reference, rows, columns);
      ASSERT_EQ(part.sizes(), expected.sizes());
      EXPECT_TRUE(torch::equal(part.to(torch::kDouble), expected));
      part.square().sum().backward();
      expected.square().sum().backward();
      EXPECT_TRUE(torch::equal(weight.grad().to(torch::kDouble), reference.grad()));
    }
  }
}

}  // namespace
}  // namespace knuckle
