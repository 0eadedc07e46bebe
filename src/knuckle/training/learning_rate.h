// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "knuckle/core/options.h"

namespace knuckle {

/// How the learning rate changes over a training.
struct LearningRateOptions {
  double learning_rate = 2e-3;      ///< the largest, (0, 100]
  std::string schedule = "cosine";  ///< cosine | step | constant
  double warm_up = 0.02;            ///< part of the training in which it rises from 0, [0, 1)
  double final_share = 0.01;        ///< cosine: the last learning rate in parts of the largest, [0, 1]
  double step_factor = 0.1;         ///< step: what it is multiplied with at each step, (0, 1]
  int rate_steps = 2;               ///< step: how many of them, evenly spread, [1, 1000]

  void visit(OptionVisitor& visitor);
};

/// At a progress in (0, 1]: how much of the training will be done after the step.
double learning_rate_at(const LearningRateOptions& options, double progress);

}  // namespace knuckle
