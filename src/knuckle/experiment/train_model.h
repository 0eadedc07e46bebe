// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "knuckle/experiment/step.h"

namespace knuckle {

/// How models are trained.
struct TrainingOptions {
  std::string device = "cpu";        ///< of networks: cpu | cuda | cuda:N
  std::filesystem::path cache = {};  ///< of networks: folder for cut-out hands; empty: they are not kept
  int workers = 1;                   ///< processes that a training runs as, [1, kMostWorkers]
  std::vector<std::string> starter =
      {};  ///< command that starts them, as in {"srun", ...}; empty: they start each other
};

/// Trains as `knuckle train KIND --config CONFIG --out OUT` does, in a process of its own, with `--resume`
/// where an earlier run with the same inputs left a checkpoint. Throws an Error with the training's own
/// message where it fails.
void train_model(const std::string& kind, const std::filesystem::path& config, const TrainingOptions& options,
                 StepStart start, const std::filesystem::path& out);

/// Removes what a finished training needs no more: a network's checkpoint is several times as large as it.
void remove_training_checkpoint(const std::filesystem::path& model);

}  // namespace knuckle
