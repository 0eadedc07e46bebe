// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_training.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/training/freed_memory.h"
#include "knuckle/training/pose_training_task.h"
#include "knuckle/training/torch_errors.h"
#include "knuckle/training/torch_threads.h"
#include "knuckle/training/trainer.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 2> kOptimisers = {"adamw", "sgd"};
constexpr std::array<std::string_view, 2> kPrecisions = {"single", "bfloat16"};
constexpr std::array<std::string_view, 2> kKept = {"best", "last"};

PatchQuestions questions_of(const NetworkOptions& network) {
  return {.side = network.dense.tells_side, .hand = network.dense.tells_hand};
}

/// Throws an Error where a network cannot be trained so.
void check_training(const NetworkOptions& network, const NetworkTrainingOptions& options,
                    const CubeSamples& validation) {
  check(network, "training");
  if (options.batch_size == options.shards && network.architecture != "dense") {
    fail(
        "training: batch_size is {} in {} shards, expected at least 2 samples per shard: the norms need them",
        options.batch_size, options.shards);
  }
  if (validation.size() == 0) fail("training: there is no sample to validate on");
}

}  // namespace

void NetworkTrainingOptions::visit(OptionVisitor& visitor) {
  visitor.real("epochs", epochs, open_closed(0, 1e6));
  visitor.integer("batch_size", batch_size, closed(1, 65536));
  visitor.integer("shards", shards, closed(1, 256));
  visitor.choice("optimiser", optimiser, kOptimisers);
  visitor.choice("precision", precision, kPrecisions);
  visitor.real("momentum", momentum, closed_open(0, 1));
  visitor.real("weight_decay", weight_decay, closed(0, 1));
  visitor.real("gradient_clip", gradient_clip, closed(0, 1e6));
  visitor.real("average_decay", average_decay, closed_open(0, 1));
  learning_rate.visit(visitor);
  visitor.integer("validate_every", validate_every, closed(1, 1e9));
  visitor.integer("patience", patience, closed(0, 1e6));
  visitor.choice("keep", keep, kKept);
  visitor.seed("seed", seed);
}

bool has_run_out_of_patience(const std::vector<TrainingMetrics>& metrics,
                             const NetworkTrainingOptions& options) {
  if (options.patience == 0 || metrics.empty()) return false;
  const auto error = [](const TrainingMetrics& m) { return m.validation.back(); };
  const auto best = std::ranges::min_element(metrics, {}, error);
  return metrics.end() - best > options.patience;
}

std::string metrics_csv(const std::vector<TrainingMetrics>& metrics,
                        std::span<const std::string_view> names) {
  std::string csv = "step,samples,learning_rate,training_loss,";
  for (const std::string_view name : names) csv += fmt::format("validation_{},", name);
  csv += "samples_per_second,waiting_share\n";
  for (const TrainingMetrics& m : metrics) {
    csv += fmt::format("{},{},{:.6g},{:.6g},", m.step, m.samples, m.learning_rate, m.training_loss);
    for (const double score : m.validation) csv += fmt::format("{:.3f},", score);
    csv += fmt::format("{:.1f},{:.4f}\n", m.samples_per_second, m.waiting_share);
  }
  return csv;
}

std::vector<TrainingMetrics> train(const TrainingTask& task, const NetworkTrainingOptions& options,
                                   const NetworkTrainingRun& run) {
  check_options(options, "training");
  if (options.batch_size % options.shards != 0) {
    fail("training: batch_size is {}, expected a multiple of shards, {}", options.batch_size, options.shards);
  }
  if (run.workers != nullptr && run.workers->size() > options.shards) {
    fail(
        "training: there are {} workers for {} shards, expected at most one worker per shard: lower "
        "--workers, or raise "
        "shards, which changes the result",
        run.workers->size(), options.shards);
  }
  use_calling_thread_alone();
  keep_freed_memory();
  return with_clear_errors("training", [&] { return Trainer(task, options, run).train(); });
}

std::vector<TrainingMetrics> train_network(const NetworkOptions& network,
                                           const NetworkTrainingOptions& options,
                                           const AugmentationOptions& augmentation,
                                           const std::vector<TrainingCrops>& training,
                                           const CubeSamples& validation, const NetworkTrainingRun& run) {
  check_training(network, options, validation);
  auto views = std::make_shared<const CubeSampleViews>(training, augmentation, questions_of(network));
  return train(PoseTrainingTask(network, augmentation, std::move(views), validation), options, run);
}

std::vector<TrainingMetrics> train_network(const NetworkOptions& network,
                                           const NetworkTrainingOptions& options,
                                           const AugmentationOptions& augmentation,
                                           const std::vector<StreamedCrops>& training,
                                           const StreamingOptions& streaming, const CubeSamples& validation,
                                           const NetworkTrainingRun& run) {
  check_training(network, options, validation);
  auto views =
      std::make_shared<const StreamedViews>(training, augmentation, questions_of(network), streaming);
  return train(PoseTrainingTask(network, augmentation, std::move(views), validation), options, run);
}

}  // namespace knuckle
