// SPDX-License-Identifier: Apache-2.0
#include "knuckle/cli/forest_training.h"

#include <cstdio>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/text.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/prepare/pose_forest_training.h"
#include "knuckle/prepare/segmentation_forest_training.h"
#include "knuckle/segment/segmentation_forest.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::cli {
namespace {

bool is_first(const WorkerGroup* workers) {
  return workers == nullptr || workers->rank() == 0;
}

/// Where a training keeps what is done: worker 0 alone. A fresh one starts without what an earlier one left.
std::filesystem::path checkpoint_of(const ForestArguments& arguments, const WorkerGroup* workers) {
  if (!is_first(workers)) return {};
  std::filesystem::path checkpoint = arguments.out.string() + ".checkpoint";
  if (!arguments.resume) remove_checkpoint(checkpoint);
  return checkpoint;
}

void print_exchange(const WorkerGroup* workers, const Stopwatch& watch) {
  if (workers == nullptr) return;
  fmt::print(
      "{} workers; {:.1f}% of the time went into what they tell each other, waiting included; "
      "worker 0 sent {:.1f} MB\n",
      workers->size(), 100.0 * workers->seconds_in_exchange() / watch.seconds(),
      static_cast<double>(workers->bytes_sent()) / 1e6);
}

/// A training with its checkpoint; worker 0 says of each of `all` trees when it was done.
TrainingRun run_of(const ForestArguments& arguments, int all, const Stopwatch& watch,
                   const WorkerGroup* workers) {
  TrainingRun run{.checkpoint = checkpoint_of(arguments, workers)};
  if (!is_first(workers)) return run;
  run.tree_done = [all, &watch](int trees) {
    fmt::print("tree {} of {} done after {:.1f} s\n", trees, all, watch.seconds());
    std::fflush(stdout);
  };
  return run;
}

void train(const ForestArguments& arguments, const PoseForestTrainingConfig& config, WorkerGroup* workers) {
  if (is_first(workers)) check_writable(arguments.out);
  const Stopwatch watch;
  const TrainingRun run = run_of(arguments, config.forest.forest.trees, watch, workers);
  const std::optional<PoseForestTraining> training =
      workers == nullptr ? run_training(config, run) : run_training(config, run, *workers);
  if (!training) return;
  save_pose_forest(arguments.out, training->model);
  write_resolved_options(arguments.out, config.resolved_options);
  print_exchange(workers, watch);
  const auto& [total, without_hand, with_missing_joints] = training->frames;
  fmt::print("{} of {} frames used ({} without a hand, {} with missing joints), {:.1f} s: {}\n",
             training->frames.used(), total, without_hand, with_missing_joints, watch.milliseconds() / 1000.0,
             printable(arguments.out.string()));
}

void train(const ForestArguments& arguments, const SegmentationForestTrainingConfig& config,
           WorkerGroup* workers) {
  if (is_first(workers)) check_writable(arguments.out);
  const Stopwatch watch;
  const TrainingRun run = run_of(arguments, config.forest.trees, watch, workers);
  const std::optional<SegmentationForestTraining> training =
      workers == nullptr ? run_training(config, run) : run_training(config, run, *workers);
  if (!training) return;
  save_segmentation_forest(arguments.out, training->forest);
  write_resolved_options(arguments.out, config.resolved_options);
  print_exchange(workers, watch);
  fmt::print(
      "{} pixels of {} frames ({:.2f} GB, collected in {:.1f} s), {} nodes, {:.1f} s: {} ({:.2f} MB)\n",
      training->samples, training->frames, static_cast<double>(training->sample_bytes) / 1e9,
      training->collection_s, training->forest.parts().trees.nodes.size(), watch.milliseconds() / 1000.0,
      arguments.out.string(), static_cast<double>(std::filesystem::file_size(arguments.out)) / 1e6);
}

template <class Config>
ForestTraining prepared(const ForestArguments& arguments) {
  const auto config = std::make_shared<const Config>(Config::load(arguments.config));
  return {config->resolved_options,
          [arguments, config](WorkerGroup* workers) { train(arguments, *config, workers); }};
}

/// Adds `train NAME`, all of whose kinds are told the same.
void add_kind(CLI::App& train, const std::string& name, const std::string& description,
              const std::string& config, ForestTraining (*prepare)(const ForestArguments&),
              void (*run)(const ForestArguments& arguments, const ForestTraining& training)) {
  CLI::App& verb = add_verb(train, name, description,
                            fmt::format("knuckle train {} --config {} --out forest.model", name, config));
  auto arguments = std::make_shared<ForestArguments>();
  verb.add_option("--config", arguments->config,
                  "Source and options of the training (pipelines/train_*.toml)")
      ->type_name("FILE")
      ->required();
  verb.add_option("--out", arguments->out, "File for the model")->type_name("FILE")->required();
  verb.add_flag("--resume", arguments->resume,
                "Go on where a training of the same configuration was stopped");
  verb.add_option("--workers", arguments->workers,
                  "Processes that train together, 1 to 1024: started on this machine, or by srun on several")
      ->check(CLI::Range(1, 1024).description(""))
      ->type_name("N")
      ->capture_default_str();
  verb.add_option("--wait", arguments->wait_s,
                  "How long a worker that does not come or answer is waited for [s], 5 to 86400")
      ->check(CLI::Range(5.0, 86400.0).description(""))
      ->type_name("SECONDS")
      ->capture_default_str();
  verb.callback([arguments, prepare, run] { run(*arguments, prepare(*arguments)); });
}

}  // namespace

void add_train_forests(CLI::App& train,
                       void (*run)(const ForestArguments& arguments, const ForestTraining& training)) {
  add_kind(train, "pose-forest", "Train a regression forest that infers poses from patches",
           "pipelines/train_pose_forest.toml", prepared<PoseForestTrainingConfig>, run);
  add_kind(train, "segmentation-forest", "Train a forest that finds hands by their pixels",
           "pipelines/train_segmentation_forest.toml", prepared<SegmentationForestTrainingConfig>, run);
}

}  // namespace knuckle::cli
