// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/train_model.h"

#include <vector>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/experiment/own_program.h"
#include "knuckle/forest/forest_growth.h"

namespace knuckle {
namespace {

std::filesystem::path checkpoint_of(const std::filesystem::path& model) {
  return model.string() + ".checkpoint";
}

/// A forest has a checkpoint of whole trees, and one of the tree that grows.
bool has_checkpoint(const std::filesystem::path& model) {
  return std::filesystem::exists(checkpoint_of(model)) ||
         std::filesystem::exists(tree_checkpoint(checkpoint_of(model)));
}

}  // namespace

void train_model(const std::string& kind, const std::filesystem::path& config, const TrainingOptions& options,
                 StepStart start, const std::filesystem::path& out) {
  std::vector<std::string> arguments = {
      "train", kind,         "--config",  config.string(),
      "--out", out.string(), "--threads", fmt::format("{}", thread_count())};
  if (kind == "network") {
    arguments.insert(arguments.end(), {"--device", options.device});
    if (!options.cache.empty()) arguments.insert(arguments.end(), {"--cache", options.cache.string()});
  }
  if (options.workers > 1)
    arguments.insert(arguments.end(), {"--workers", fmt::format("{}", options.workers)});
  if (start == StepStart::again && has_checkpoint(out)) arguments.emplace_back("--resume");
  if (start == StepStart::anew) std::filesystem::remove(out);
  run_own_program(arguments, options.starter);
  if (!std::filesystem::exists(out)) {
    fail("{}: its training came to its end but left no model: no validation gave a finite error",
         out.string());
  }
}

void remove_training_checkpoint(const std::filesystem::path& model) {
  remove_checkpoint(checkpoint_of(model));
}

}  // namespace knuckle
