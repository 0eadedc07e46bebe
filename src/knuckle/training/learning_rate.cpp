// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/learning_rate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 3> kSchedules = {"cosine", "step", "constant"};

}  // namespace

void LearningRateOptions::visit(OptionVisitor& visitor) {
  visitor.real("learning_rate", learning_rate, open_closed(0, 100));
  visitor.choice("schedule", schedule, kSchedules);
  visitor.real("warm_up", warm_up, closed_open(0, 1));
  visitor.real("final_share", final_share, closed(0, 1));
  visitor.real("step_factor", step_factor, open_closed(0, 1));
  visitor.integer("rate_steps", rate_steps, closed(1, 1000));
}

double learning_rate_at(const LearningRateOptions& options, double progress) {
  if (progress < options.warm_up) return options.learning_rate * progress / options.warm_up;
  const double rest = (progress - options.warm_up) / (1.0 - options.warm_up);
  if (options.schedule == "cosine") {
    const double wave = 0.5 * (1.0 + std::cos(std::numbers::pi * rest));
    return options.learning_rate * (options.final_share + (1.0 - options.final_share) * wave);
  }
  if (options.schedule == "step") {
    const double steps = std::floor(rest * (options.rate_steps + 1));
    return options.learning_rate * std::pow(options.step_factor, std::min<double>(steps, options.rate_steps));
  }
  return options.learning_rate;
}

}  // namespace knuckle
