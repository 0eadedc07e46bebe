// SPDX-License-Identifier: Apache-2.0
// The program `knuckle-train-forest`: `knuckle train pose-forest` and `segmentation-forest` go on here where
// several workers train, so that `knuckle` itself need not load LibTorch, whose c10d connects them.
#include <fmt/format.h>

#include "knuckle/cli/forest_training.h"
#include "knuckle/cli/verb.h"
#include "knuckle/workers/work_together.h"

namespace knuckle::cli {
namespace {

void train_forest(const ForestArguments& arguments, const ForestTraining& training) {
  work_together(
      {.workers = arguments.workers,
       .wait_s = arguments.wait_s,
       .command_line = command_line_arguments(),
       .traits = {{"other options", fmt::format("{}\n{}", training.resolved_options, arguments.resume)}},
       .advice = "go on with --resume, with any number of workers"},
      training.train);
}

void add_verbs(CLI::App& program) {
  CLI::App& train = *program.add_subcommand("train", "Train a model");
  train.require_subcommand(1);
  add_train_forests(train, train_forest);
}

}  // namespace
}  // namespace knuckle::cli

int main(int count, char** arguments) {
  return knuckle::cli::run_program("Trains forests by several workers for `knuckle train`.",
                                   knuckle::cli::add_verbs, count, arguments);
}
