// SPDX-License-Identifier: Apache-2.0
#include "knuckle/cli/forest_training.h"
#include "knuckle/cli/network_arguments.h"
#include "knuckle/cli/sibling_program.h"
#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"

namespace knuckle::cli {
namespace {

/// Workers are connected by LibTorch, which the program loads that needs it.
void train_forest(const ForestArguments& arguments, const ForestTraining& training) {
  if (arguments.workers > 1) become_sibling("knuckle-train-forest");
  training.train(nullptr);
}

/// LibTorch is loaded by the program that trains with it alone.
void train_network(const NetworkArguments& /*checked*/) {
#ifdef KNUCKLE_TRAINING_NEEDS_AVX2
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    fail(
        "knuckle-train-network: needs a processor with AVX2 and FMA (most since 2013), which this one has "
        "not");
  }
#endif
  become_sibling("knuckle-train-network");
}

}  // namespace

void add_train(CLI::App& program) {
  CLI::App& train = *program.add_subcommand("train", "Train a model");
  train.footer(
      "Example:\n  knuckle train pose-forest --config pipelines/train_pose_forest.toml --out forest.model");
  train.require_subcommand(1);
  add_train_forests(train, train_forest);
  add_train_network(train, train_network);
}

}  // namespace knuckle::cli
