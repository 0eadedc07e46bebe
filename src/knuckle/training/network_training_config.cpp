// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_training_config.h"

#include <algorithm>
#include <array>
#include <optional>

#include "knuckle/core/error.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/prepare/sample_cache.h"

namespace knuckle {
namespace {

constexpr double kBytesPerGigabyte = 1e9;

std::int64_t frames_of(const std::string& source, int most) {
  const std::int64_t size = open_source(source)->size();
  return most > 0 ? std::min<std::int64_t>(most, size) : size;
}

void check_memory(const NetworkTrainingConfig& config) {
  const NetworkSampleOptions& samples = config.samples;
  const std::int64_t count = frames_of(config.source, samples.most) +
                             frames_of(config.validation, samples.most_validation) +
                             (samples.most_things > 0 ? frames_of(config.source, samples.most_things) : 0);
  const double gigabytes =
      static_cast<double>(CubeSamples::bytes(count, config.network.joint_count(), samples.crop_px)) /
      kBytesPerGigabyte;
  if (gigabytes > samples.memory_gb) {
    fail("{} samples take {:.2f} GB, more than memory_gb, {}: lower `most` or `crop_px`", count, gigabytes,
         samples.memory_gb);
  }
}

/// Call it when a HandFinder was made from the document: then its tables are read.
Inputs inputs_of_finder(const OptionTable& document) {
  const OptionTable segmentation = document.table("segmentation");
  Inputs inputs;
  inputs.add("hand", document.table("hand").resolved_toml())
      .add("segmentation", segmentation.resolved_toml());
  if (segmentation.has("model")) {
    inputs.add_content("model", segmentation.resolved_path(segmentation.required_text("model")));
  }
  return inputs;
}

}  // namespace

void NetworkSampleOptions::visit(OptionVisitor& visitor) {
  static constexpr std::array<std::string_view, 2> kCentres{"segmentation", "joints"};
  visitor.integer("most", most, closed(0, 1e9));
  visitor.integer("most_validation", most_validation, closed(0, 1e9));
  visitor.integer("most_things", most_things, closed(0, 1e9));
  visitor.integer("crop_px", crop_px, closed(2, 4096));
  visitor.choice("centre", centre, kCentres);
  visitor.real("memory_gb", memory_gb, open_closed(0, 10000));
}

NetworkTrainingConfig NetworkTrainingConfig::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  NetworkTrainingConfig config{.source = source_in(document, "source"),
                               .validation = source_in(document, "validation"),
                               .initial = {},
                               .detector = {},
                               .start = start_from_name(document.choice_or("start", "nearest", kStartNames)),
                               .finder = HandFinder(document),
                               .segmentation = inputs_of_finder(document),
                               .samples = {},
                               .network = {},
                               .augmentation = {},
                               .training = {},
                               .resolved_options = {}};
  const std::string initial = document.text_or("initial", "");
  if (!initial.empty()) config.initial = document.resolved_path(initial);
  const std::string detector = document.text_or("detector", "");
  if (!detector.empty()) config.detector = document.resolved_path(detector);
  document.table("patch").read(config.network.patch);
  document.table("samples").read(config.samples);
  document.table("network").read(config.network);
  document.table("augmentation").read(config.augmentation);
  document.table("training").read(config.training);
  document.finish();
  check(config.network, path.string());
  if (config.samples.most_things > 0 && config.detector.empty())
    fail("{}: most_things is {}, and no 'detector' is named that finds them", path.string(),
         config.samples.most_things);
  config.resolved_options = document.resolved_toml();
  return config;
}

NetworkTrainingResult run_network_training(const NetworkTrainingConfig& config, const NetworkTrainingRun& run,
                                           const std::filesystem::path& cache_folder) {
  check_memory(config);
  const SampleCache cache(cache_folder);
  SampleOptions options{.convention = convention_from_name(config.network.convention),
                        .patch = {config.network.patch.size_px, config.network.patch.cube_mm},
                        .crop_px = config.samples.crop_px,
                        .start = config.start,
                        .around_joints = config.samples.centre == "joints",
                        .most = config.samples.most_validation};
  const NetworkSamples validation =
      cache.samples(config.validation, config.finder, config.segmentation, options);
  options.most = config.samples.most;
  const NetworkSamples training = cache.samples(config.source, config.finder, config.segmentation, options);
  std::optional<NetworkSamples> things;
  if (config.samples.most_things > 0) {
    options.most = config.samples.most_things;
    things.emplace(cache.things(config.source, config.detector, options));
  }
  NetworkTrainingRun begun = run;
  begun.initial = config.initial;
  return {train_network(config.network, config.training, config.augmentation,
                        {training.samples, things ? &things->samples : nullptr}, validation.samples, begun),
          training.frames, validation.frames};
}

}  // namespace knuckle
