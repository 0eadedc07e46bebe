// SPDX-License-Identifier: Apache-2.0
// The program `knuckle-train-network`: `knuckle train network` goes on here, so that `knuckle` itself need
// not load LibTorch. It understands the same command line.
#include <cstdio>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "knuckle/cli/network_arguments.h"
#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/eval/pictures/figures.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/training/detector_training.h"
#include "knuckle/training/network_training_config.h"
#include "knuckle/training/torch_device.h"

namespace knuckle::cli {
namespace {

/// What is told of the trainings of one kind of network.
struct KindOfNetwork {
  std::span<const std::string_view> score_names;
  std::string (*validation_text)(const std::vector<double>& scores);
  std::string_view curve_label;                                  ///< of the axis of the curves
  std::vector<std::pair<std::string_view, std::size_t>> curves;  ///< names, and which scores they show
};

std::string pose_validation_text(const std::vector<double>& scores) {
  return fmt::format("{:.2f} mm at first, {:.2f} mm at second look", scores[kFirstLook], scores[kSecondLook]);
}

std::string detector_validation_text(const std::vector<double>& scores) {
  return fmt::format(
      "{:.1f}% of hands found, {:.3f} per frame that are none, side right in {:.1f}%, {:.1f} mm off",
      100.0 * scores[kRecall], scores[kFalsePositives], 100.0 * scores[kSideAccuracy], scores[kCentreMm]);
}

const KindOfNetwork& pose_networks() {
  static const KindOfNetwork kind{kPoseScoreNames,
                                  pose_validation_text,
                                  "mean 3D error [mm]",
                                  {{"first look", kFirstLook}, {"second look", kSecondLook}}};
  return kind;
}

const KindOfNetwork& detectors() {
  static const KindOfNetwork kind{kDetectorScoreNames,
                                  detector_validation_text,
                                  "share",
                                  {{"hands found", kRecall},
                                   {"false positives per frame", kFalsePositives},
                                   {"side right", kSideAccuracy}}};
  return kind;
}

void print_metrics(const TrainingMetrics& metrics, const KindOfNetwork& kind) {
  fmt::print(
      "step {}: {} samples, loss {:.4f}, validation {}; {:.0f} samples/s, {:.1f}% of the time waited for "
      "data\n",
      metrics.step, metrics.samples, metrics.training_loss, kind.validation_text(metrics.validation),
      metrics.samples_per_second, 100.0 * metrics.waiting_share);
  std::fflush(stdout);
}

/// The curves of a training as STEM_curves.svg and .png.
void write_curves(const std::filesystem::path& model, const std::vector<TrainingMetrics>& metrics,
                  const KindOfNetwork& kind) {
  Figure figure{.kind = FigureKind::curves,
                .name = model.stem().string() + "_curves",
                .title = "Validation of " + model.filename().string(),
                .x_label = "training samples [thousands]",
                .y_label = std::string(kind.curve_label),
                .x = {},
                .categories = {},
                .series = {},
                .y_end = std::nullopt};
  for (const TrainingMetrics& m : metrics) figure.x.push_back(static_cast<double>(m.samples) / 1000.0);
  for (const auto& [name, score] : kind.curves) {
    auto& series = figure.series.emplace_back();
    series.name = name;
    for (const TrainingMetrics& m : metrics) series.values.push_back(m.validation[score]);
  }
  const std::filesystem::path folder = model.has_parent_path() ? model.parent_path() : ".";
  write_figures(std::span(&figure, 1), folder);
}

NetworkTrainingRun run_of(const NetworkArguments& arguments, const KindOfNetwork& kind) {
  const std::filesystem::path& out = arguments.out;
  NetworkTrainingRun run;
  run.model = out;
  run.checkpoint = out.string() + ".checkpoint";
  if (arguments.resume) {
    run.begin = NetworkTrainingRun::Begin::from_checkpoint;
  } else {
    remove_checkpoint(run.checkpoint);  // what an earlier training left
  }
  run.device = arguments.device;
  run.minutes = arguments.minutes;
  run.report = [out, &kind](const std::vector<TrainingMetrics>& metrics) {
    print_metrics(metrics.back(), kind);
    write_text_file(out.string() + ".metrics.csv", metrics_csv(metrics, kind.score_names));
  };
  return run;
}

void train_pose_network(const NetworkArguments& arguments) {
  const auto config = NetworkTrainingConfig::load(arguments.config);
  check_writable(arguments.out);
  const NetworkTrainingRun run = run_of(arguments, pose_networks());
  write_resolved_options(arguments.out, config.resolved_options);
  const Stopwatch watch;
  const NetworkTrainingResult result = run_network_training(config, run, arguments.cache);
  if (result.metrics.size() > 1) write_curves(arguments.out, result.metrics, pose_networks());
  fmt::print("{} of {} frames used ({} without a hand, {} found elsewhere), {:.1f} s: {}\n",
             result.frames.used(), result.frames.total, result.frames.without_hand, result.frames.off_centre,
             watch.milliseconds() / 1000.0, arguments.out.string());
}

void train_detector(const NetworkArguments& arguments) {
  const auto config = DetectorTrainingConfig::load(arguments.config);
  if (!arguments.cache.empty()) {
    fail("--cache keeps hands that were cut out of frames, but a detector sees whole frames: leave it out");
  }
  check_writable(arguments.out);
  const NetworkTrainingRun run = run_of(arguments, detectors());
  write_resolved_options(arguments.out, config.resolved_options);
  const Stopwatch watch;
  const std::vector<TrainingMetrics> metrics = run_detector_training(config, run);
  if (metrics.size() > 1) write_curves(arguments.out, metrics, detectors());
  fmt::print("{:.1f} s: {}\n", watch.milliseconds() / 1000.0, arguments.out.string());
}

void train_network(const NetworkArguments& arguments) {
  device_from_name(arguments.device);  // before frames are rendered and an earlier checkpoint is removed
  if (is_of_detector(arguments.config)) {
    train_detector(arguments);
  } else {
    train_pose_network(arguments);
  }
}

void add_verbs(CLI::App& program) {
  CLI::App& train = *program.add_subcommand("train", "Train a model");
  train.require_subcommand(1);
  add_train_network(train, train_network);
}

}  // namespace
}  // namespace knuckle::cli

int main(int count, char** arguments) {
  return knuckle::cli::run_program("Trains networks for `knuckle train network`.", knuckle::cli::add_verbs,
                                   count, arguments);
}
