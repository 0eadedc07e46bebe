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
#include "knuckle/core/progress.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/eval/pictures/figures.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/training/blas_kernels.h"
#include "knuckle/training/detector_training.h"
#include "knuckle/training/network_training_config.h"
#include "knuckle/training/torch_device.h"
#include "knuckle/training/training_check.h"
#include "knuckle/workers/work_together.h"

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

void print_metrics(const TrainingMetrics& metrics, const KindOfNetwork& kind, double seconds_left) {
  fmt::print(
      "step {}: {} samples, loss {:.4f}, validation {}; {:.0f} samples/s, {:.1f}% of the time waited for "
      "data, time left {}\n",
      metrics.step, metrics.samples, metrics.training_loss, kind.validation_text(metrics.validation),
      metrics.samples_per_second, 100.0 * metrics.waiting_share, readable_duration(seconds_left));
  std::fflush(stdout);
}

/// A file beside the model: "dense.pt" and "_check.png" give "dense_check.png".
std::filesystem::path beside(const std::filesystem::path& model, const std::string& ending) {
  return model.parent_path() / (model.stem().string() + ending);
}

/// The curves of a training as STEM_curves.svg and .png. They go with a training: where they cannot be drawn
/// it goes on.
void write_curves(const std::filesystem::path& model, const std::vector<TrainingMetrics>& metrics,
                  const KindOfNetwork& kind) {
  if (metrics.size() < 2) return;  // no line yet
  Figure figure{.kind = FigureKind::curves,
                .name = model.stem().string() + "_curves",
                .title = "Validation of " + model.filename().string(),
                .x_label = "training samples [thousands]",
                .y_label = std::string(kind.curve_label),
                .x = {},
                .categories = {},
                .series = {},
                .y = std::nullopt};
  for (const TrainingMetrics& m : metrics) figure.x.push_back(static_cast<double>(m.samples) / 1000.0);
  for (const auto& [name, score] : kind.curves) {
    auto& series = figure.series.emplace_back();
    series.name = name;
    for (const TrainingMetrics& m : metrics) series.values.push_back(m.validation[score]);
  }
  const std::filesystem::path folder = model.has_parent_path() ? model.parent_path() : ".";
  try {
    write_figures(std::span(&figure, 1), folder);
  } catch (const Error& error) {
    fmt::print(stderr, "warning: {}\n", printable(error.what()));
  }
}

bool is_first(const WorkerGroup* workers) {
  return workers == nullptr || workers->rank() == 0;
}

NetworkTrainingRun run_of(const NetworkArguments& arguments, const KindOfNetwork& kind,
                          WorkerGroup* workers) {
  const std::filesystem::path& out = arguments.out;
  NetworkTrainingRun run;
  run.model = out;
  run.checkpoint = out.string() + ".checkpoint";
  if (arguments.resume) {
    run.begin = NetworkTrainingRun::Begin::from_checkpoint;
  } else if (is_first(workers)) {
    remove_checkpoint(run.checkpoint);  // what an earlier training left
  }
  run.workers = workers;
  run.device = arguments.device;
  run.minutes = arguments.minutes;
  run.report_initial = [&kind](const std::vector<double>& validation) {
    fmt::print("before training: validation {}\n", kind.validation_text(validation));
    std::fflush(stdout);
  };
  run.report = [out, &kind](const std::vector<TrainingMetrics>& metrics, double seconds_left) {
    print_metrics(metrics.back(), kind, seconds_left);
    write_text_file(out.string() + ".metrics.csv", metrics_csv(metrics, kind.score_names));
    write_curves(out, metrics, kind);
  };
  return run;
}

void print_early_end(const std::vector<TrainingMetrics>& metrics, const NetworkTrainingOptions& options) {
  if (has_run_out_of_patience(metrics, options))
    fmt::print("ended early: {} validations were no better than the best (patience)\n", options.patience);
}

void warn_of_unknown(const std::vector<Landmark>& landmarks) {
  std::vector<std::string> names;
  for (const Landmark landmark : landmarks) names.emplace_back(name_of(landmark));
  fmt::print(stderr, "warning: no sample labels {}: the network learns nothing of it\n", joined(names));
}

/// Shows what a network would be trained on.
void check_pose_network(const NetworkArguments& arguments, const NetworkTrainingConfig& config) {
  const TrainingCheck check = check_network_training(config);
  const std::filesystem::path sheet = beside(arguments.out, "_check.png");
  write_png(sheet, check.sheet);
  fmt::print("{}samples as they will be seen, each with the number of its set: {}\n", check.text,
             sheet.string());
}

TogetherOptions together(const NetworkArguments& arguments, const std::string& options) {
  return {.workers = arguments.workers,
          .wait_s = arguments.wait_s,
          .command_line = command_line_arguments(),
          .traits = {{"other options", fmt::format("{}\n{}\n{}\n{}", options, arguments.resume,
                                                   arguments.device, arguments.minutes)}},
          .advice = "go on with --resume, with any number of workers"};
}

void print_exchange(WorkerGroup* workers, const Stopwatch& watch) {
  if (workers == nullptr) return;
  fmt::print("{} workers; {:.1f}% of the time went into what they tell each other, waiting included\n",
             workers->size(), 100.0 * workers->seconds_in_exchange() / watch.seconds());
}

void train_pose_network(const NetworkArguments& arguments, const NetworkTrainingConfig& config,
                        WorkerGroup* workers) {
  if (is_first(workers)) check_writable(arguments.out);
  const NetworkTrainingRun run = run_of(arguments, pose_networks(), workers);
  if (is_first(workers)) write_resolved_options(arguments.out, config.resolved_options);
  const Stopwatch watch;
  const NetworkTrainingResult result = run_network_training(config, run, arguments.cache, warn_of_unknown);
  print_early_end(result.metrics, config.training);
  print_exchange(workers, watch);
  fmt::print("{} of {} frames used ({} without a hand, {} found elsewhere), {:.1f} s: {}\n",
             result.frames.used(), result.frames.total, result.frames.without_hand, result.frames.off_centre,
             watch.milliseconds() / 1000.0, printable(arguments.out.string()));
}

void train_pose_network(const NetworkArguments& arguments) {
  const auto config = NetworkTrainingConfig::load(arguments.config);
  if (arguments.check) {
    check_pose_network(arguments, config);
    return;
  }
  work_together(together(arguments, config.resolved_options),
                [&](WorkerGroup* workers) { train_pose_network(arguments, config, workers); });
}

void train_detector(const NetworkArguments& arguments, const DetectorTrainingConfig& config,
                    WorkerGroup* workers) {
  if (is_first(workers)) check_writable(arguments.out);
  const NetworkTrainingRun run = run_of(arguments, detectors(), workers);
  if (is_first(workers)) write_resolved_options(arguments.out, config.resolved_options);
  const Stopwatch watch;
  const std::vector<TrainingMetrics> metrics = run_detector_training(config, run);
  print_early_end(metrics, config.training);
  print_exchange(workers, watch);
  fmt::print("{:.1f} s: {}\n", watch.milliseconds() / 1000.0, printable(arguments.out.string()));
}

void train_detector(const NetworkArguments& arguments) {
  const auto config = DetectorTrainingConfig::load(arguments.config);
  if (arguments.check)
    fail("--check shows hands that are cut out, but a detector sees whole frames: leave it out");
  if (!arguments.cache.empty()) {
    fail("--cache keeps hands that were cut out of frames, but a detector sees whole frames: leave it out");
  }
  work_together(together(arguments, config.resolved_options),
                [&](WorkerGroup* workers) { train_detector(arguments, config, workers); });
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
  knuckle::use_better_blas_kernels(arguments);
  return knuckle::cli::run_program("Trains networks for `knuckle train network`.", knuckle::cli::add_verbs,
                                   count, arguments);
}
