// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/fully_connected_layer.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

std::vector<Half> random_halves(std::size_t count, std::uint64_t stream) {
  Random random(5, stream);
  std::vector<Half> halves(count);
  for (Half& half : halves) half = half_of_float(static_cast<float>(random.uniform(-1.0, 1.0)));
  return halves;
}

std::vector<float> random_floats(std::size_t count, std::uint64_t stream) {
  std::vector<float> floats;
  for (const Half half : random_halves(count, stream)) floats.push_back(float_of_half(half));
  return floats;
}

class FullyConnectedLayers : public ::testing::TestWithParam<std::pair<int, int>> {};

INSTANTIATE_TEST_SUITE_P(, FullyConnectedLayers,
                         ::testing::Values(std::pair{1, 1}, std::pair{3, 2}, std::pair{20, 60},
                                           std::pair{129, 63}, std::pair{64, 64}, std::pair{200, 65},
                                           std::pair{7776, 20}, std::pair{65, 200}));

TEST_P(FullyConnectedLayers, AreTheDefinition) {
  const auto [inputs, outputs] = GetParam();
  const std::vector<Half> weights = random_halves(static_cast<std::size_t>(inputs) * outputs, 1);
  const std::vector<float> scales = random_floats(static_cast<std::size_t>(outputs), 2);
  const std::vector<float> shifts = random_floats(static_cast<std::size_t>(outputs), 4);
  const FoldedNorm norm{{scales.begin(), scales.end()}, {shifts.begin(), shifts.end()}};
  std::vector<float> input = random_floats(static_cast<std::size_t>(inputs), 3);
  for (float& value : input) value = std::max(value, 0.0f);  // zeros among them, as after a ReLU
  const std::vector<float> linear =
      FullyConnectedLayer(inputs, outputs, Activation::linear, weights, norm).apply(input);
  const std::vector<float> rectified =
      FullyConnectedLayer(inputs, outputs, Activation::relu, weights, norm).apply(input);
  ASSERT_EQ(linear.size(), static_cast<std::size_t>(outputs));
  for (int o = 0; o < outputs; ++o) {
    double sum = 0.0;
    for (int i = 0; i < inputs; ++i) {
      sum += static_cast<double>(input[i]) * float_of_half(weights[static_cast<std::size_t>(o) * inputs + i]);
    }
    EXPECT_NEAR(linear[o], norm.scales[o] * sum + norm.shifts[o], 2e-6 * std::sqrt(inputs)) << o;
    EXPECT_EQ(rectified[o], std::max(linear[o], 0.0f)) << o;
  }
}

}  // namespace
}  // namespace knuckle
