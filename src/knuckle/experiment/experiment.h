// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "knuckle/experiment/plan.h"
#include "knuckle/experiment/train_model.h"

namespace knuckle {

/// How an experiment is run.
struct ExperimentOptions {
  std::filesystem::path out;  ///< folder of all that is made
  /// Folder of trained models, used where it holds the plan's files; may be empty.
  std::filesystem::path models;
  double scale = 1.0;  ///< (0, 1]: how much of everything is trained and tested, see scale.h
  TrainingOptions training;
};

class JobQueue;

/// Runs a plan from data to report:
///
///     OUT/training/FILE.toml         what the training of a model is told
///     OUT/models/FILE                trained, or copied from `models`
///     OUT/pipelines/NAME.toml        the pipelines under test
///     OUT/SEQUENCE/boxes/NAME.csv    what each segmentation found
///     OUT/SEQUENCE/poses/NAME.txt    what each estimation found (started at the true palm, as in the paper)
///     OUT/SEQUENCE/report.html       the scores of each sequence, with pictures
///     OUT/tables, OUT/timings        the numbers as CSV; only timings differ from run to run
///     OUT/report.html                the whole
///
/// Models, boxes, poses and report are steps that are done only where their inputs changed (see step.h), so
/// an experiment that was stopped goes on where it was. Returns the path of the report. Throws an Error where
/// a file of the plan is missing or wrong.
std::filesystem::path run_experiment(const ExperimentPlan& plan, const ExperimentOptions& options);

/// The same with the steps as jobs of a queue (step_jobs.h), beside one another where none needs the other.
/// A job does `run_experiment_step`. The results are the same.
std::filesystem::path run_experiment_as_jobs(const ExperimentPlan& plan, const ExperimentOptions& options,
                                             JobQueue& queue, int most_jobs);

/// Does one step, named by its output as in "models/dense.pt", unless it is done. Throws an Error where the
/// experiment has no such step, or what the step needs is not there.
void run_experiment_step(const ExperimentPlan& plan, const ExperimentOptions& options,
                         const std::string& name);

}  // namespace knuckle
