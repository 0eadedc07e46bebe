// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/experiment/plan.h"

namespace knuckle {

/// How an experiment is run.
struct ExperimentOptions {
  std::filesystem::path out;  ///< folder of all that is made
  std::filesystem::path
      models;          ///< folder of trained models, used where it holds the plan's files; may be empty
  double scale = 1.0;  ///< part of all frames, for training and testing, (0, 1]
};

/// Runs a plan from data to report:
///
///     OUT/models/FILE                trained, or copied from `models`
///     OUT/pipelines/NAME.toml        the pipelines under test
///     OUT/SEQUENCE/boxes/NAME.csv    what each segmentation found
///     OUT/SEQUENCE/poses/NAME.txt    what each estimation found (started at the true palm, as in the paper)
///     OUT/report.html                and the scores of each sequence beside its boxes and poses
///
/// Each of these is a step that is done only where its inputs changed (see step.h), so an experiment that was
/// stopped goes on where it was. Returns the path of the report. Throws an Error where a file of the plan is
/// missing or wrong.
std::filesystem::path run_experiment(const ExperimentPlan& plan, const ExperimentOptions& options);

}  // namespace knuckle
