// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/detector_training.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/prepare/training_source.h"
#include "knuckle/training/detector_training_task.h"

namespace knuckle {
namespace {

constexpr std::int64_t kMostAtOnce = 1024;  ///< frames that are read together

double gigabytes_of(std::int64_t frames, const DetectorOptions& network) {
  constexpr double kGigabyte = 1e9;
  return static_cast<double>(DetectorSamples::bytes(frames, network)) / kGigabyte;
}

void require_memory(const DetectorTrainingConfig& config, std::int64_t training, std::int64_t validation) {
  const double gigabytes = gigabytes_of(training + validation, config.network);
  if (gigabytes > config.samples.memory_gb) {
    fail(
        "{} samples take {:.2f} GB, more than memory_gb, {}: lower `most`, or have frames read when they are "
        "needed by `stream = true` in [samples]",
        training + validation, gigabytes, config.samples.memory_gb);
  }
}

/// How many frames are read together; one reading is used while the next is made. Throws an Error where there
/// is no room for a batch in each.
std::int64_t most_at_once(const DetectorTrainingConfig& config, std::int64_t validation) {
  const int batch = config.training.batch_size;
  const double gigabytes = gigabytes_of(validation + 2 * batch, config.network);
  if (gigabytes > config.samples.memory_gb) {
    fail(
        "{} samples of the validation and two batches of {} take {:.2g} GB, more than memory_gb, {}: lower "
        "`most_validation` or `batch_size`",
        validation, batch, gigabytes, config.samples.memory_gb);
  }
  const double left = config.samples.memory_gb - gigabytes_of(validation, config.network);
  const double twice = left / gigabytes_of(1, config.network);
  return static_cast<std::int64_t>(
      std::min(static_cast<double>(std::max<std::int64_t>(kMostAtOnce, batch)), 0.5 * twice));
}

void check_sizes(const DetectorOptions& network, std::int64_t training, std::int64_t validation) {
  check(network, "training");
  if (training == 0) fail("training: there is no sample to train on");
  if (validation == 0) fail("training: there is no sample to validate on");
}

/// The tables `[[source]]`, of which each may say `most`; or the one source.
std::vector<DetectorSource> sources_of(const OptionTable& document, int most) {
  std::vector<DetectorSource> sources;
  for (const OptionTable& table : source_tables_in(document)) {
    DetectorSource& source = sources.emplace_back(DetectorSource{source_in(table, "source"), most});
    table.read(source);
  }
  if (sources.empty()) sources.push_back({one_source_in(document), most});
  return sources;
}

}  // namespace

void DetectorSampleOptions::visit(OptionVisitor& visitor) {
  visitor.integer("most", most, closed(0, 1e9));
  visitor.integer("most_validation", most_validation, closed(0, 1e9));
  visitor.real("memory_gb", memory_gb, open_closed(0, 10000));
  visitor.flag("stream", stream);
}

bool is_of_detector(const std::filesystem::path& config) {
  return OptionTable::load(config).table("network").text_or("architecture", "") == kDetectorArchitecture;
}

DetectorTrainingConfig DetectorTrainingConfig::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  DetectorTrainingConfig config;
  const std::string initial = document.text_or("initial", "");
  if (!initial.empty()) config.initial = document.resolved_path(initial);
  document.table("samples").read(config.samples);
  config.sources = sources_of(document, config.samples.most);
  config.validation = {source_in(document, "validation"), config.samples.most_validation};
  static constexpr std::array kKnown{kDetectorArchitecture};
  document.table("network").choice_or("architecture", kDetectorArchitecture, kKnown);
  document.table("network").read(config.network);
  document.table("augmentation").read(config.augmentation);
  document.table("training").read(config.training);
  document.finish();
  check(config.network, path.string());
  config.resolved_options = document.resolved_toml();
  return config;
}

std::vector<TrainingMetrics> train_detector(const DetectorOptions& network,
                                            const NetworkTrainingOptions& options,
                                            const DetectorAugmentation& augmentation,
                                            const DetectorSamples& training,
                                            const DetectorSamples& validation,
                                            const NetworkTrainingRun& run) {
  check_sizes(network, training.size(), validation.size());
  auto views = std::make_shared<const DetectorSampleViews>(training, augmentation);
  return train(DetectorTrainingTask(network, augmentation, std::move(views), validation), options, run);
}

std::vector<TrainingMetrics> train_detector(const DetectorOptions& network,
                                            const NetworkTrainingOptions& options,
                                            const DetectorAugmentation& augmentation,
                                            const DetectorFrames& training, std::int64_t most_at_once,
                                            const DetectorSamples& validation,
                                            const NetworkTrainingRun& run) {
  check_sizes(network, training.size(), validation.size());
  auto views = std::make_shared<const StreamedDetectorViews>(training, augmentation, most_at_once);
  return train(DetectorTrainingTask(network, augmentation, std::move(views), validation), options, run);
}

std::vector<TrainingMetrics> run_detector_training(const DetectorTrainingConfig& config,
                                                   const NetworkTrainingRun& run) {
  const DetectorFrames training(config.sources, config.network);
  const DetectorFrames validating({&config.validation, 1}, config.network);
  NetworkTrainingRun begun = run;
  begun.initial = config.initial;
  if (config.samples.stream) {
    const std::int64_t at_once = most_at_once(config, validating.size());
    return train_detector(config.network, config.training, config.augmentation, training, at_once,
                          samples_of(validating), begun);
  }
  require_memory(config, training.size(), validating.size());
  return train_detector(config.network, config.training, config.augmentation, samples_of(training),
                        samples_of(validating), begun);
}

}  // namespace knuckle
