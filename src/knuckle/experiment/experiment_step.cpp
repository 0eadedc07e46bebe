// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/experiment_step.h"

#include <fmt/format.h>

namespace knuckle {

void run_here(const ExperimentStep& step) {
  run_step(step.output, step.inputs(), [&](StepStart start) {
    if (!step.title.empty()) fmt::print("{}\n", step.title);
    step.work(start);
  });
  step.tidy();
}

}  // namespace knuckle
