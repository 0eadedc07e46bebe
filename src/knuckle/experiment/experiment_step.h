// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "knuckle/experiment/step.h"

namespace knuckle {

/// A step of an experiment: what it makes, of what, and how.
struct ExperimentStep {
  std::string name;              ///< of its output in the experiment's folder, as in "models/dense.pt"
  std::filesystem::path output;  ///< the same with the folder
  std::string title;             ///< said when it begins, as in "training dense.pt"; empty: not worth a word
  std::vector<std::string> needs;  ///< names of the steps that make its inputs
  bool is_copy = false;            ///< copies files: too short for a job
  bool is_training = false;        ///< runs as so many processes as TrainingOptions::workers says
  std::function<Inputs()> inputs;  ///< read when all that it needs is done
  std::function<void(StepStart)> work;
  std::function<void()> tidy = [] {};  ///< removes what nobody needs once the step is done
};

/// Does the step in this process, unless it is done.
void run_here(const ExperimentStep& step);

}  // namespace knuckle
