// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <torch/types.h>

#include "knuckle/training/tensor_pieces.h"

namespace knuckle {

struct NetworkTrainingOptions;

/// Moves weights against their gradient, by SGD with momentum or AdamW (Loshchilov and Hutter 2019), and a
/// moving average after them. What LibTorch's optimisers do, in one pass through memory and on all threads:
/// weights, gradients and moments of the paper's networks are 200 MB each.
class Optimiser {
 public:
  /// `parameters` and `averages` are moved by `step`.
  Optimiser(std::vector<torch::Tensor> parameters, std::vector<torch::Tensor> averages,
            const NetworkTrainingOptions& options);

  /// Length of the gradient of all parameters.
  double gradient_norm() const;

  /// How far one step goes.
  struct Step {
    double learning_rate;
    double gradient_scale;  ///< the gradient is multiplied with it first
    double average_decay;   ///< share of the average that stays, [0, 1)
  };
  void step(const Step& step);

  /// What has to be kept for going on: moments, one list after another.
  const std::vector<torch::Tensor>& moments() const { return moments_; }
  std::int64_t steps() const { return steps_; }
  void set_steps(std::int64_t steps) { steps_ = steps; }

 private:
  void move_sgd(const std::vector<torch::Tensor>& pieces, const Step& step) const;
  void move_adamw(const std::vector<torch::Tensor>& pieces, const Step& step) const;
  std::vector<torch::Tensor> gradients() const;

  std::vector<torch::Tensor> parameters_;
  std::vector<torch::Tensor> averages_;
  std::vector<torch::Tensor> moments_;  // sgd: one per parameter; adamw: the first of all, then the second
  TensorPieces pieces_;
  bool is_adamw_;
  double momentum_;
  double weight_decay_;
  std::int64_t steps_ = 0;
};

}  // namespace knuckle
