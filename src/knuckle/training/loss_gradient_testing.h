// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <gtest/gtest.h>
#include <torch/utils.h>

#include "knuckle/core/random.h"
#include "knuckle/training/trainable_module.h"

namespace knuckle::testing {

/// Compares the gradient of a network's loss in its output with central differences, at 60 random places. All
/// tensors are in double precision.
inline void expect_gradient_of_finite_differences(TrainableModule& network, const torch::Tensor& patches,
                                                  const torch::Tensor& joints, torch::Tensor output) {
  constexpr double kStep = 1e-6;
  constexpr double kTolerance = 1e-7;
  output.set_requires_grad(true);
  network.loss(output, patches, joints).backward();
  const torch::Tensor gradient = output.grad().view(-1);
  ASSERT_TRUE(torch::isfinite(gradient).all().item<bool>());
  ASSERT_GT(gradient.abs().max().item<double>(), 1e-5) << "the differences are of something";
  const torch::NoGradGuard no_gradient;
  const torch::Tensor values = output.view(-1);
  Random random(1);
  for (int i = 0; i < 60; ++i) {
    const auto place = static_cast<int64_t>(random.below(static_cast<std::uint32_t>(values.numel())));
    const double before = values[place].item<double>();
    values[place] = before + kStep;
    const double above = network.loss(output, patches, joints).item<double>();
    values[place] = before - kStep;
    const double below = network.loss(output, patches, joints).item<double>();
    values[place] = before;
    EXPECT_NEAR(gradient[place].item<double>(), (above - below) / (2.0 * kStep), kTolerance) << place;
  }
}

}  // namespace knuckle::testing
