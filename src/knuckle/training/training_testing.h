// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <filesystem>
#include <string>

#include "knuckle/training/network_training.h"

namespace knuckle::testing {

/// 4 steps on 8 samples, validated after each second.
inline NetworkTrainingOptions short_training() {
  NetworkTrainingOptions options;
  options.epochs = 2.0;
  options.batch_size = 4;
  options.shards = 2;
  options.validate_every = 2;
  return options;
}

/// A run from the beginning whose files are FOLDER/NAME.pt and FOLDER/NAME.checkpoint.
inline NetworkTrainingRun run_in(const std::filesystem::path& folder, const std::string& name) {
  NetworkTrainingRun run;
  run.model = folder / (name + ".pt");
  run.checkpoint = folder / (name + ".checkpoint");
  return run;
}

}  // namespace knuckle::testing
