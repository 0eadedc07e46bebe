// SPDX-License-Identifier: Apache-2.0
// The program `knuckle-train-network`: `knuckle train network` goes on here, so that `knuckle` itself need
// not load LibTorch. It understands the same command line.
#include <cstdio>

#include <fmt/format.h>

#include "knuckle/cli/network_arguments.h"
#include "knuckle/cli/verb.h"
#include "knuckle/eval/pictures/figures.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/training/network_training_config.h"
#include "knuckle/training/torch_device.h"

namespace knuckle::cli {
namespace {

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
                .series = {{"first look", {}}, {"second look", {}}},
                .y_end = std::nullopt};
  for (const TrainingMetrics& m : metrics) {
    figure.x.push_back(static_cast<double>(m.samples) / 1000.0);
    figure.series[0].values.push_back(m.validation.first_mm);
    figure.series[1].values.push_back(m.validation.second_mm);
  }
  const std::filesystem::path folder = model.has_parent_path() ? model.parent_path() : ".";
  write_figures(std::span(&figure, 1), folder);
}

NetworkTrainingRun run_of(const NetworkArguments& arguments) {
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
  run.report = [out](const std::vector<TrainingMetrics>& metrics) {
    print_metrics(metrics.back());
    write_text_file(out.string() + ".metrics.csv", metrics_csv(metrics));
  };
  return run;
}

void train_network(const NetworkArguments& arguments) {
  device_from_name(arguments.device);  // before frames are rendered and an earlier checkpoint is removed
  const auto config = NetworkTrainingConfig::load(arguments.config);
  check_writable(arguments.out);
  const NetworkTrainingRun run = run_of(arguments);
  write_resolved_options(arguments.out, config.resolved_options);
  const Stopwatch watch;
  const NetworkTrainingResult result = run_network_training(config, run, arguments.cache);
  if (result.metrics.size() > 1) write_curves(arguments.out, result.metrics);
  fmt::print("{} of {} frames used ({} without a hand, {} found elsewhere), {:.1f} s: {}\n",
             result.frames.used(), result.frames.total, result.frames.without_hand, result.frames.off_centre,
             watch.milliseconds() / 1000.0, arguments.out.string());
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
