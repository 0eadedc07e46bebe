// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_training_config.h"

#include <algorithm>
#include <array>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/training/configured_samples.h"

namespace knuckle {
namespace {

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

/// The source of the frames that are not trained on; empty where the sets hold some out.
std::string validation_in(const OptionTable& document, const std::vector<TrainingSource>& sources) {
  const bool is_held_out =
      std::ranges::any_of(sources, [](const TrainingSource& source) { return source.holdout > 0.0; });
  if (!is_held_out && !document.has("validation")) {
    document.fail_at(
        "validation",
        "is missing, expected the source of frames to validate on (a text), or a `holdout` of the "
        "frames of `source`, such as 0.1");
  }
  if (!is_held_out) return source_in(document, "validation");
  if (document.has("validation"))
    document.fail_at("validation", "stands beside `holdout`, which says what to validate on: leave one out");
  return {};
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
  visitor.flag("stream", stream);
  visitor.integer("stream_window", stream_window, closed(1, 1e9));
}

namespace {

/// Where the network's landmarks lie: its convention may be named by the file that says so.
std::optional<LandmarkDefinition> definition_in(const OptionTable& document, NetworkOptions& network) {
  if (!network.convention.ends_with(".toml")) return definition_of_own_landmarks(network.landmarks());
  LandmarkDefinition definition = LandmarkDefinition::load(document.resolved_path(network.convention));
  network.convention = convention_text(definition.convention);
  return definition;
}

}  // namespace

NetworkTrainingConfig NetworkTrainingConfig::load(const std::filesystem::path& path) {
  const OptionTable document = OptionTable::load(path);
  if (!document.has("source")) document.required_text("source");  // says what is missing
  NetworkTrainingConfig config{.sources = {},
                               .validation = {},
                               .initial = {},
                               .detector = {},
                               .start = start_from_name(document.choice_or("start", "nearest", kStartNames)),
                               .finder = HandFinder(document),
                               .segmentation = inputs_of_finder(document),
                               .samples = {},
                               .network = {},
                               .definition = {},
                               .augmentation = {},
                               .training = {},
                               .resolved_options = {}};
  const std::string initial = document.text_or("initial", "");
  if (!initial.empty()) config.initial = document.resolved_path(initial);
  const std::string detector = document.text_or("detector", "");
  if (!detector.empty()) config.detector = document.resolved_path(detector);
  document.table("patch").read(config.network.patch);
  document.table("samples").read(config.samples);
  config.sources = training_sources_in(document, {.source = {},
                                                  .side = config.finder.hand().is_left() ? "left" : "right",
                                                  .most = config.samples.most,
                                                  .most_things = config.samples.most_things});
  config.validation = validation_in(document, config.sources);
  document.table("network").read(config.network);
  config.definition = definition_in(document, config.network);
  document.table("augmentation").read(config.augmentation);
  document.table("training").read(config.training);
  document.finish();
  check(config.network, path.string());
  for (const TrainingSource& source : config.sources) {
    if (source.most_things > 0 && config.detector.empty()) {
      fail("{}: most_things is {}, and no 'detector' is named that finds them", path.string(),
           source.most_things);
    }
  }
  config.resolved_options = document.resolved_toml();
  return config;
}

NetworkTrainingResult run_network_training(const NetworkTrainingConfig& config, const NetworkTrainingRun& run,
                                           const std::filesystem::path& cache,
                                           const TakeUnknownLandmarks& unknown) {
  check_sources(config);
  // What worker 0 puts into the cache is there for the others.
  const bool waits = run.workers != nullptr && !cache.empty();
  if (waits && run.workers->rank() > 0) gathered(*run.workers, "cached");
  const ConfiguredSamples samples =
      config.samples.stream ? streamed_samples(config, cache) : configured_samples(config, cache);
  if (waits && run.workers->rank() == 0) gathered(*run.workers, "cached");
  const std::vector<Landmark> landmarks = unknown_landmarks(config, samples);
  if (unknown && !landmarks.empty()) unknown(landmarks);
  NetworkTrainingRun begun = run;
  begun.initial = config.initial;
  const CubeSamples& validation = samples.validation.samples;
  std::vector<TrainingMetrics> metrics =
      config.samples.stream
          ? train_network(config.network, config.training, config.augmentation, samples.streams,
                          streaming_options(config, validation), validation, begun)
          : train_network(config.network, config.training, config.augmentation, samples.crops(), validation,
                          begun);
  return {std::move(metrics), samples.frames(), samples.validation.frames};
}

}  // namespace knuckle
