// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include "knuckle/core/worker_group.h"

namespace knuckle::cli {

/// What `knuckle train pose-forest` and `segmentation-forest` are told.
struct ForestArguments {
  std::filesystem::path config;
  std::filesystem::path out;
  bool resume = false;
  int workers = 1;        ///< processes that train together
  double wait_s = 300.0;  ///< how long one of them that does not come or answer is waited for [s]
};

/// A training whose configuration was read.
struct ForestTraining {
  std::string resolved_options;                     ///< the configuration with all defaults filled in
  std::function<void(WorkerGroup* workers)> train;  ///< nullptr: alone. Writes the model, as worker 0.
};

/// Adds both verbs to `train`. Two programs know them: `knuckle`, which trains alone or starts the other one,
/// and `knuckle-train-forest`, where several workers train.
void add_train_forests(CLI::App& train,
                       void (*run)(const ForestArguments& arguments, const ForestTraining& training));

}  // namespace knuckle::cli
