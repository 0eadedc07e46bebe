// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include <fmt/format.h>

#include "knuckle/cli/network_arguments.h"
#include "knuckle/cli/sibling_program.h"
#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/prepare/pose_forest_training.h"
#include "knuckle/prepare/segmentation_forest_training.h"
#include "knuckle/segment/segmentation_forest.h"
#include "knuckle/storage/file_io.h"

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
  if (!arguments.resume) remove_checkpoint(checkpoint);
  return checkpoint;
}

void train_pose_forest(const TrainArguments& arguments) {
  check_writable(arguments.out);
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

void train_segmentation_forest(const TrainArguments& arguments) {
  check_writable(arguments.out);
  const auto config = SegmentationForestTrainingConfig::load(arguments.config);
  const Stopwatch watch;
  TrainingRun run{.checkpoint = checkpoint_of(arguments)};
  run.tree_done = [&](int trees) {
    fmt::print("tree {} of {} done after {:.1f} s\n", trees, config.forest.trees,
               watch.milliseconds() / 1000.0);
    std::fflush(stdout);
  };
  const SegmentationForestTraining training = run_training(config, run);
  save_segmentation_forest(arguments.out, training.forest);
  write_resolved_options(arguments.out, config.resolved_options);
  fmt::print(
      "{} pixels of {} frames ({:.2f} GB, collected in {:.1f} s), {} nodes, {:.1f} s: {} ({:.2f} MB)\n",
      training.samples, training.frames, static_cast<double>(training.sample_bytes) / 1e9,
      training.collection_s, training.forest.parts().trees.nodes.size(), watch.milliseconds() / 1000.0,
      arguments.out.string(), static_cast<double>(std::filesystem::file_size(arguments.out)) / 1e6);
}

/// Adds `train NAME`, all of whose kinds are told the same.
void add_kind(CLI::App& train, const std::string& name, const std::string& description,
              const std::string& config, void (*run)(const TrainArguments& arguments)) {
  CLI::App& verb = add_verb(train, name, description,
                            fmt::format("knuckle train {} --config {} --out forest.model", name, config));
  auto arguments = std::make_shared<TrainArguments>();
  verb.add_option("--config", arguments->config,
                  "Source and options of the training (pipelines/train_*.toml)")
      ->type_name("FILE")
      ->required();
  verb.add_option("--out", arguments->out, "File for the model")->type_name("FILE")->required();
  verb.add_flag("--resume", arguments->resume,
                "Go on where a training of the same configuration was stopped");
  verb.callback([arguments, run] { run(*arguments); });
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
  add_kind(train, "pose-forest", "Train a regression forest that infers poses from patches",
           "pipelines/train_pose_forest.toml", train_pose_forest);
  add_kind(train, "segmentation-forest", "Train a forest that finds hands by their pixels",
           "pipelines/train_segmentation_forest.toml", train_segmentation_forest);
  add_train_network(train, train_network);
}

}  // namespace knuckle::cli
