// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/file_io.h"
#include "knuckle/eval/figures.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/pipeline/network_training_config.h"
#include "knuckle/pipeline/pose_forest_training.h"
#include "knuckle/pipeline/segmentation_forest_training.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/segment/segmentation_forest.h"

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
                            fmt::format("knuckle train {} --config {} --out forest.h5", name, config));
  auto arguments = std::make_shared<TrainArguments>();
  verb.add_option("--config", arguments->config, "Source and options of the training")->required();
  verb.add_option("--out", arguments->out, "File for the model")->required();
  verb.add_flag("--resume", arguments->resume,
                "Go on where a training of the same configuration was stopped");
  verb.callback([arguments, run] { run(*arguments); });
}

struct NetworkArguments {
  TrainArguments train;
  std::string device = "cpu";
  double minutes = 0.0;
};

void print_metrics(const TrainingMetrics& metrics) {
  fmt::print(
      "step {}: {} samples, loss {:.4f}, validation {:.2f} mm at first, {:.2f} mm at second look; {:.0f} "
      "samples/s, "
      "{:.1f}% of the time waited for data\n",
      metrics.step, metrics.samples, metrics.training_loss, metrics.validation.first_mm,
      metrics.validation.second_mm, metrics.samples_per_second, 100.0 * metrics.waiting_share);
  std::fflush(stdout);
}

/// The curves of a training as STEM_curves.svg and .png.
void write_curves(const std::filesystem::path& model, const std::vector<TrainingMetrics>& metrics) {
  Figure figure{.kind = FigureKind::curves,
                .name = model.stem().string() + "_curves",
                .title = "Validation of " + model.filename().string(),
                .x_label = "training samples [thousands]",
                .y_label = "mean 3D error [mm]",
                .x = {},
                .categories = {},
                .series = {{"first look", {}}, {"second look", {}}}};
  for (const TrainingMetrics& m : metrics) {
    figure.x.push_back(static_cast<double>(m.samples) / 1000.0);
    figure.series[0].values.push_back(m.validation.first_mm);
    figure.series[1].values.push_back(m.validation.second_mm);
  }
  const std::filesystem::path folder = model.has_parent_path() ? model.parent_path() : ".";
  write_figures(std::span(&figure, 1), folder);
}

void train_network(const NetworkArguments& arguments) {
  const auto config = NetworkTrainingConfig::load(arguments.train.config);
  const std::filesystem::path& out = arguments.train.out;
  NetworkTrainingRun run{.model = out,
                         .checkpoint = checkpoint_of(arguments.train),
                         .begin = arguments.train.resume ? NetworkTrainingRun::Begin::from_checkpoint
                                                         : NetworkTrainingRun::Begin::anew,
                         .initial = {},
                         .device = arguments.device,
                         .minutes = arguments.minutes,
                         .stop_after_steps = 0,
                         .report = [&](const std::vector<TrainingMetrics>& metrics) {
                           print_metrics(metrics.back());
                           write_text_file(out.string() + ".metrics.csv", metrics_csv(metrics));
                         }};
  write_resolved_options(out,
                         config.resolved_options);  // first: a folder that cannot be written to ends it here
  const Stopwatch watch;
  const NetworkTrainingResult result = run_network_training(config, run);
  if (result.metrics.size() > 1) write_curves(out, result.metrics);
  fmt::print("{} of {} frames used ({} without a hand, {} found elsewhere), {:.1f} s: {}\n",
             result.frames.used(), result.frames.total, result.frames.without_hand, result.frames.off_centre,
             watch.milliseconds() / 1000.0, out.string());
}

void add_train_network(CLI::App& train) {
  CLI::App& network =
      add_verb(train, "network", "Train a convolutional network that infers poses from patches",
               "knuckle train network --config pipelines/train_dense.toml --out dense.pt");
  auto arguments = std::make_shared<NetworkArguments>();
  network
      .add_option("--config", arguments->train.config, "Sources, network, augmentation and training options")
      ->required();
  network.add_option("--out", arguments->train.out, "File for the model")->required();
  network.add_flag("--resume", arguments->train.resume,
                   "Go on where a training of the same configuration was stopped");
  network.add_option("--device", arguments->device, "cpu | cuda")->capture_default_str();
  network
      .add_option("--minutes", arguments->minutes,
                  "Be done with training in this time; the result then depends on the machine's speed")
      ->check(CLI::NonNegativeNumber);
  network.callback([arguments] { train_network(*arguments); });
}

}  // namespace

void add_train(CLI::App& program) {
  CLI::App& train = *program.add_subcommand("train", "Train a model");
  train.require_subcommand(1);
  add_kind(train, "pose-forest", "Train a regression forest that infers poses from patches",
           "pipelines/train_pose_forest.toml", train_pose_forest);
  add_kind(train, "segmentation-forest", "Train a forest that finds hands by their pixels",
           "pipelines/train_segmentation_forest.toml", train_segmentation_forest);
  add_train_network(train);
}

}  // namespace knuckle::cli
