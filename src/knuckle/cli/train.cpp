// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/file_io.h"
#include "knuckle/pipeline/pose_forest_training.h"
#include "knuckle/pipeline/stopwatch.h"

namespace knuckle::cli {
namespace {

struct TrainArguments {
  std::filesystem::path config;
  std::filesystem::path out;
  bool resume = false;
};

/// Where a training keeps what is done. A fresh one starts without what an earlier one left.
std::filesystem::path checkpoint_of(const TrainArguments& arguments) {
  std::filesystem::path checkpoint = arguments.out.string() + ".checkpoint";
  if (!arguments.resume) std::filesystem::remove(checkpoint);
  return checkpoint;
}

void train_forest(const TrainArguments& arguments) {
  const auto config = PoseForestTrainingConfig::load(arguments.config);
  const Stopwatch watch;
  const PoseForestTraining training = run_training(config, checkpoint_of(arguments));
  save_pose_forest(arguments.out, training.model);
  write_resolved_options(arguments.out, config.resolved_options);
  const auto& [total, without_hand, with_missing_joints] = training.frames;
  fmt::print("{} of {} frames used ({} without a hand, {} with missing joints), {:.1f} s: {}\n",
             training.frames.used(), total, without_hand, with_missing_joints, watch.milliseconds() / 1000.0,
             arguments.out.string());
}

}  // namespace

void add_train(CLI::App& program) {
  CLI::App& train = *program.add_subcommand("train", "Train a model");
  train.require_subcommand(1);
  CLI::App& forest =
      add_verb(train, "pose-forest", "Train a regression forest that infers poses from patches",
               "knuckle train pose-forest --config pipelines/train_pose_forest.toml --out forest.h5");
  auto arguments = std::make_shared<TrainArguments>();
  forest.add_option("--config", arguments->config, "Source, segmentation, patch and forest options")
      ->required();
  forest.add_option("--out", arguments->out, "File for the model")->required();
  forest.add_flag("--resume", arguments->resume,
                  "Go on where a training of the same configuration was stopped");
  forest.callback([arguments] { train_forest(*arguments); });
}

}  // namespace knuckle::cli
