// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/detector_training.h"

#include <algorithm>

#include "knuckle/core/error.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/training/detector_training_task.h"

namespace knuckle {
namespace {

constexpr double kBytesPerGigabyte = 1e9;

void check_memory(const DetectorTrainingConfig& config) {
  const auto frames_of = [](const std::string& source, int most) {
    const std::int64_t size = open_source(source)->size();
    return most > 0 ? std::min<std::int64_t>(most, size) : size;
  };
  const std::int64_t count = frames_of(config.source, config.samples.most) +
                             frames_of(config.validation, config.samples.most_validation);
  const double gigabytes =
      static_cast<double>(DetectorSamples::bytes(count, config.network)) / kBytesPerGigabyte;
  if (gigabytes > config.samples.memory_gb) {
    fail("{} samples take {:.2f} GB, more than memory_gb, {}: lower `most`", count, gigabytes,
         config.samples.memory_gb);
  }
}

}  // namespace

void DetectorSampleOptions::visit(OptionVisitor& visitor) {
  visitor.integer("most", most, closed(0, 1e9));
  visitor.integer("most_validation", most_validation, closed(0, 1e9));
  visitor.real("memory_gb", memory_gb, open_closed(0, 10000));
}

bool is_of_detector(const std::filesystem::path& config) {
  return OptionTable::load(config).table("network").text_or("architecture", "") == kDetectorArchitecture;
}

DetectorTrainingConfig DetectorTrainingConfig::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  DetectorTrainingConfig config;
  config.source = source_in(document, "source");
  config.validation = source_in(document, "validation");
  const std::string initial = document.text_or("initial", "");
  if (!initial.empty()) config.initial = document.resolved_path(initial);
  document.table("samples").read(config.samples);
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
  check(network, "training");
  if (training.size() == 0) fail("training: there is no sample to train on");
  if (validation.size() == 0) fail("training: there is no sample to validate on");
  return train(DetectorTrainingTask(network, augmentation, training, validation), options, run);
}

std::vector<TrainingMetrics> run_detector_training(const DetectorTrainingConfig& config,
                                                   const NetworkTrainingRun& run) {
  check_memory(config);
  const DetectorSamples validation =
      detector_samples(config.validation, config.network, config.samples.most_validation);
  const DetectorSamples training = detector_samples(config.source, config.network, config.samples.most);
  NetworkTrainingRun begun = run;
  begun.initial = config.initial;
  return train_detector(config.network, config.training, config.augmentation, training, validation, begun);
}

}  // namespace knuckle
