// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/optimiser.h"

#include <memory>

#include <gtest/gtest.h>
#include <torch/optim/adamw.h>
#include <torch/optim/sgd.h>
#include <torch/utils.h>

#include "knuckle/core/parallel.h"
#include "knuckle/training/network_training.h"

namespace knuckle {
namespace {

/// One tensor of several pieces, one smaller than a piece, one whose numbers are not in order.
std::vector<torch::Tensor> random_parameters() {
  torch::manual_seed(3);
  std::vector<torch::Tensor> parameters{
      torch::randn({300, 251}), torch::randn({7}),
      torch::randn({8, 64, 9, 9}).contiguous(torch::MemoryFormat::ChannelsLast)};
  for (torch::Tensor& parameter : parameters) parameter.set_requires_grad(true);
  return parameters;
}

std::vector<torch::Tensor> copies_of(const std::vector<torch::Tensor>& tensors) {
  std::vector<torch::Tensor> copies;
  for (const torch::Tensor& tensor : tensors) copies.push_back(tensor.detach().clone());
  return copies;
}

void set_gradients(const std::vector<torch::Tensor>& parameters, int64_t seed) {
  torch::manual_seed(seed);
  for (const torch::Tensor& parameter : parameters) {
    parameter.mutable_grad() = torch::randn(parameter.sizes()).contiguous(parameter.suggest_memory_format());
  }
}

std::unique_ptr<torch::optim::Optimizer> libtorchs(const std::vector<torch::Tensor>& parameters,
                                                   const NetworkTrainingOptions& options, double rate) {
  if (options.optimiser == "adamw") {
    return std::make_unique<torch::optim::AdamW>(
        parameters, torch::optim::AdamWOptions(rate).weight_decay(options.weight_decay));
  }
  return std::make_unique<torch::optim::SGD>(
      parameters,
      torch::optim::SGDOptions(rate).momentum(options.momentum).weight_decay(options.weight_decay));
}

class Optimisers : public ::testing::TestWithParam<const char*> {
 protected:
  Optimisers() {
    options_.optimiser = GetParam();
    options_.weight_decay = 0.1;
  }

  NetworkTrainingOptions options_;
};

INSTANTIATE_TEST_SUITE_P(, Optimisers, ::testing::Values("sgd", "adamw"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST_P(Optimisers, MoveAsLibTorchs) {
  constexpr double kRate = 0.02;
  constexpr double kScale = 0.5;
  const std::vector<torch::Tensor> ours = random_parameters();
  const std::vector<torch::Tensor> theirs = random_parameters();
  const std::vector<torch::Tensor> averages = copies_of(ours);
  std::vector<torch::Tensor> expected_averages = copies_of(ours);
  Optimiser optimiser(ours, averages, options_);
  const auto reference = libtorchs(theirs, options_, kRate);
  for (int step = 0; step < 4; ++step) {
    set_gradients(ours, step);
    set_gradients(theirs, step);
    optimiser.step({kRate, kScale, 0.75});
    const torch::NoGradGuard no_gradient;
    for (const torch::Tensor& parameter : theirs) parameter.grad().mul_(kScale);
    reference->step();
    for (std::size_t i = 0; i < theirs.size(); ++i) expected_averages[i].lerp_(theirs[i].detach(), 0.25);
  }
  for (std::size_t i = 0; i < ours.size(); ++i) {
    EXPECT_TRUE(torch::allclose(ours[i], theirs[i], 1e-4, 1e-6)) << i;
    EXPECT_TRUE(torch::allclose(averages[i], expected_averages[i], 1e-4, 1e-6)) << i;
  }
}

TEST_P(Optimisers, DoNotDependOnThreads) {
  const auto moved = [&](int threads) {
    set_thread_count(threads);
    const std::vector<torch::Tensor> parameters = random_parameters();
    Optimiser optimiser(parameters, copies_of(parameters), options_);
    set_gradients(parameters, 1);
    const double norm = optimiser.gradient_norm();
    optimiser.step({0.1, 1.0 / norm, 0.5});
    set_thread_count(0);
    return parameters;
  };
  const std::vector<torch::Tensor> one = moved(1);
  const std::vector<torch::Tensor> three = moved(3);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_TRUE(torch::equal(one[i], three[i])) << i;
}

TEST(Optimiser, MeasuresTheWholeGradient) {
  const std::vector<torch::Tensor> parameters = random_parameters();
  set_gradients(parameters, 2);
  double squares = 0.0;
  for (const torch::Tensor& parameter : parameters) {
    squares += parameter.grad().to(torch::kDouble).square().sum().item<double>();
  }
  EXPECT_NEAR(Optimiser(parameters, copies_of(parameters), {}).gradient_norm(), std::sqrt(squares),
              1e-4 * std::sqrt(squares));
}

}  // namespace
}  // namespace knuckle
