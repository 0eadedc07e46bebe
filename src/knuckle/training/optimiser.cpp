// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/optimiser.h"

#include <cmath>
#include <utility>

#include <torch/utils.h>

#include "knuckle/training/network_training.h"

namespace knuckle {
namespace {

// AdamW's, as everywhere (Kingma and Ba 2015).
constexpr double kFirstDecay = 0.9;
constexpr double kSecondDecay = 0.999;
constexpr double kEpsilon = 1e-8;

std::vector<torch::Tensor> zeros_like(const std::vector<torch::Tensor>& tensors) {
  std::vector<torch::Tensor> zeros;
  for (const torch::Tensor& tensor : tensors) zeros.push_back(torch::zeros_like(tensor.detach()));
  return zeros;
}

}  // namespace

Optimiser::Optimiser(std::vector<torch::Tensor> parameters, std::vector<torch::Tensor> averages,
                     const NetworkTrainingOptions& options)
    : parameters_(std::move(parameters)),
      averages_(std::move(averages)),
      moments_(zeros_like(parameters_)),
      pieces_(parameters_),
      is_adamw_(options.optimiser == "adamw"),
      momentum_(options.momentum),
      weight_decay_(options.weight_decay) {
  if (!is_adamw_) return;
  for (torch::Tensor& second : zeros_like(parameters_)) moments_.push_back(std::move(second));
}

std::vector<torch::Tensor> Optimiser::gradients() const {
  std::vector<torch::Tensor> gradients;
  for (const torch::Tensor& parameter : parameters_) gradients.push_back(parameter.grad());
  return gradients;
}

double Optimiser::gradient_norm() const {
  std::vector<double> squares(static_cast<std::size_t>(pieces_.size()));
  pieces_.for_each({gradients()}, [&](int64_t index, const std::vector<torch::Tensor>& pieces) {
    const auto length = pieces[0].norm().item<double>();
    squares[static_cast<std::size_t>(index)] = length * length;
  });
  double sum = 0.0;
  for (const double square : squares) sum += square;
  return std::sqrt(sum);
}

void Optimiser::step(const Step& step) {
  ++steps_;
  const auto count = static_cast<std::ptrdiff_t>(parameters_.size());
  std::vector<std::vector<torch::Tensor>> lists{parameters_, averages_, gradients()};
  for (auto begin = moments_.begin(); begin != moments_.end(); begin += count) {
    lists.emplace_back(begin, begin + count);
  }
  pieces_.for_each(lists, [&](int64_t /*index*/, std::vector<torch::Tensor>& pieces) {
    pieces[2].mul_(step.gradient_scale);
    if (is_adamw_) {
      move_adamw(pieces, step);
    } else {
      move_sgd(pieces, step);
    }
    pieces[1].lerp_(pieces[0], 1.0 - step.average_decay);
  });
}

void Optimiser::move_sgd(const std::vector<torch::Tensor>& pieces, const Step& step) const {
  const torch::Tensor& weights = pieces[0];
  const torch::Tensor& gradient = pieces[2];
  const torch::Tensor& moment = pieces[3];
  moment.mul_(momentum_).add_(gradient).add_(weights, weight_decay_);
  weights.add_(moment, -step.learning_rate);
}

void Optimiser::move_adamw(const std::vector<torch::Tensor>& pieces, const Step& step) const {
  const torch::Tensor& weights = pieces[0];
  const torch::Tensor& gradient = pieces[2];
  const torch::Tensor& first = pieces[3];
  const torch::Tensor& second = pieces[4];
  const double first_share = 1.0 - std::pow(kFirstDecay, static_cast<double>(steps_));
  const double second_share = 1.0 - std::pow(kSecondDecay, static_cast<double>(steps_));
  first.mul_(kFirstDecay).add_(gradient, 1.0 - kFirstDecay);
  second.mul_(kSecondDecay).addcmul_(gradient, gradient, 1.0 - kSecondDecay);
  weights.mul_(1.0 - step.learning_rate * weight_decay_);
  weights.addcdiv_(first, second.sqrt().div_(std::sqrt(second_share)).add_(kEpsilon),
                   -step.learning_rate / first_share);
}

}  // namespace knuckle
