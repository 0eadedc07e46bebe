// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/configured_samples.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/prepare/sample_cache.h"

namespace knuckle {
namespace {

constexpr double kBytesPerGigabyte = 1e9;

std::int64_t frames_of(const std::string& name, const SampleOptions& options, int most) {
  const auto source = open_source(name);
  require_landmarks(*source, options, name);
  return most > 0 ? std::min<std::int64_t>(most, source->size()) : source->size();
}

SampleOptions options_of(const NetworkTrainingConfig& config) {
  return {.convention = config.network.landmarks(),
          .definition = config.definition,
          .patch = {config.network.patch.size_px, config.network.patch.cube_mm},
          .crop_px = config.samples.crop_px,
          .start = config.start,
          .around_joints = config.samples.centre == "joints"};
}

/// Memory of so many samples.
double gigabytes_of(const NetworkTrainingConfig& config, std::int64_t count) {
  const Convention& convention = config.network.landmarks();
  return static_cast<double>(CubeSamples::bytes(count, convention.size(), config.samples.crop_px)) /
         kBytesPerGigabyte;
}

/// The smaller of two numbers of frames, of which 0 is no limit.
std::int64_t least(std::int64_t a, std::int64_t b) {
  return a == 0 || b == 0 ? std::max(a, b) : std::min(a, b);
}

}  // namespace

SampleOptions sample_options(const NetworkTrainingConfig& config, const TrainingSource& source,
                             Holdout::Part part) {
  SampleOptions options = options_of(config);
  const bool is_left = source.side == "left";
  if (is_left != config.finder.hand().is_left()) options.side = is_left ? HandSide::left : HandSide::right;
  options.holdout = {source.holdout, part};
  return options;
}

namespace {

/// Makes the samples of a configuration one source after another.
class SampleMaker {
 public:
  SampleMaker(const NetworkTrainingConfig& config, const std::filesystem::path& cache,
              std::int64_t most_of_each)
      : config_(config), cache_(cache), most_of_each_(most_of_each) {}

  NetworkSamples validation() const {
    const std::int64_t most = least(config_.samples.most_validation, most_of_each_);
    if (!config_.validation.empty()) {
      SampleOptions options = options_of(config_);
      options.most = most;
      return made(config_.validation, options);
    }
    std::vector<NetworkSamples> parts;
    for (const TrainingSource& source : config_.sources) {
      if (source.holdout == 0.0) continue;
      SampleOptions options = sample_options(config_, source, Holdout::Part::validation);
      options.most = most;
      parts.push_back(made(source.source, options));
    }
    return joined(std::move(parts));
  }

  SetSamples set(const TrainingSource& source) const {
    SampleOptions options = sample_options(config_, source, Holdout::Part::training);
    options.most = least(source.most, most_of_each_);
    SetSamples set{made(source.source, options), std::nullopt, source.weight};
    if (source.most_things > 0) {
      options.most = least(source.most_things, most_of_each_);
      set.things.emplace(cache_.things(source.source, config_.detector, options));
    }
    return set;
  }

  StreamedCrops stream(const TrainingSource& source) const {
    SampleOptions options = sample_options(config_, source, Holdout::Part::training);
    options.most = source.most;
    StreamedCrops set{cache_.streamed(source.source, config_.finder, config_.segmentation, options), nullptr,
                      source.weight};
    if (source.most_things > 0) {
      options.most = source.most_things;
      set.things = cache_.streamed_things(source.source, config_.detector, options);
    }
    return set;
  }

 private:
  NetworkSamples made(const std::string& source, const SampleOptions& options) const {
    return cache_.samples(source, config_.finder, config_.segmentation, options);
  }

  static NetworkSamples joined(std::vector<NetworkSamples> parts) {
    if (parts.size() == 1) return std::move(parts.front());
    std::int64_t count = 0;
    for (const NetworkSamples& part : parts) count += part.samples.size();
    const CubeSamples& first = parts.front().samples;
    NetworkSamples all{CubeSamples(count, first.joint_count(), first.patch(), first.crop_px()), {}};
    std::int64_t place = 0;
    for (const NetworkSamples& part : parts) {
      for (std::int64_t i = 0; i < part.samples.size(); ++i) all.samples.set(place++, part.samples.sample(i));
      all.frames.add(part.frames);
    }
    all.samples.finish();
    return all;
  }

  const NetworkTrainingConfig& config_;
  SampleCache cache_;
  std::int64_t most_of_each_;
};

}  // namespace

std::vector<TrainingCrops> ConfiguredSamples::crops() const {
  std::vector<TrainingCrops> crops;
  crops.reserve(sets.size());
  for (const SetSamples& set : sets) crops.push_back(set.crops());
  return crops;
}

SampleFrames ConfiguredSamples::frames() const {
  SampleFrames sum;
  for (const SetSamples& set : sets) sum.add(set.hands.frames);
  for (const StreamedCrops& set : streams) sum.add(set.hands->frames());
  return sum;
}

namespace {

/// Throws an Error where samples that are not streamed take more memory than they may.
void require_memory(const NetworkTrainingConfig& config, std::int64_t count) {
  const double gigabytes = gigabytes_of(config, count);
  if (gigabytes <= config.samples.memory_gb) return;
  fail(
      "{} samples take {:.2f} GB, more than memory_gb, {}: lower `most` or `crop_px`, or have them read from "
      "--cache by `stream = true` in [samples]",
      count, gigabytes, config.samples.memory_gb);
}

/// Throws an Error where there is no room for two batches beside so many samples of the validation.
void require_memory_to_stream(const NetworkTrainingConfig& config, std::int64_t validation) {
  const double gigabytes = gigabytes_of(config, validation + 2 * config.training.batch_size);
  if (gigabytes <= config.samples.memory_gb) return;
  fail(
      "{} samples of the validation and two batches of {} take {:.2g} GB, more than memory_gb, {}: lower "
      "`most_validation`, `batch_size` or `crop_px`",
      validation, config.training.batch_size, gigabytes, config.samples.memory_gb);
}

}  // namespace

void check_sources(const NetworkTrainingConfig& config) {
  const SampleOptions options = options_of(config);
  std::int64_t count = 0;
  for (const TrainingSource& source : config.sources) {
    count += frames_of(source.source, options, source.most);
    if (source.most_things > 0) count += frames_of(source.source, options, source.most_things);
  }
  const std::int64_t validation =
      config.validation.empty() ? 0 : frames_of(config.validation, options, config.samples.most_validation);
  if (config.samples.stream) {
    require_memory_to_stream(config, validation);
  } else {
    require_memory(config, count + validation);
  }
}

StreamingOptions streaming_options(const NetworkTrainingConfig& config, const CubeSamples& validation) {
  require_memory_to_stream(config, validation.size());
  const double left = config.samples.memory_gb - gigabytes_of(config, validation.size());
  StreamingOptions options;
  options.window = config.samples.stream_window;
  const double twice = std::floor(left / gigabytes_of(config, 1));
  options.most_at_once =
      static_cast<std::int64_t>(std::min(static_cast<double>(options.most_at_once), 0.5 * twice));
  return options;
}

ConfiguredSamples configured_samples(const NetworkTrainingConfig& config, const std::filesystem::path& cache,
                                     std::int64_t most_of_each) {
  const SampleMaker maker(config, cache, most_of_each);
  ConfiguredSamples samples{{}, maker.validation()};
  for (const TrainingSource& source : config.sources) samples.sets.push_back(maker.set(source));
  return samples;
}

ConfiguredSamples streamed_samples(const NetworkTrainingConfig& config, const std::filesystem::path& cache) {
  const SampleMaker maker(config, cache, 0);
  ConfiguredSamples samples{{}, maker.validation()};
  for (const TrainingSource& source : config.sources) samples.streams.push_back(maker.stream(source));
  return samples;
}

std::vector<Landmark> unknown_landmarks(const NetworkTrainingConfig& config,
                                        const ConfiguredSamples& samples) {
  const Convention& convention = config.network.landmarks();
  std::vector<bool> known(convention.landmarks.size(), false);
  const auto add = [&](const std::vector<bool>& of_set) {
    for (std::size_t j = 0; j < known.size(); ++j) known[j] = known[j] || of_set[j];
  };
  for (const SetSamples& set : samples.sets) add(known_joints(set.hands.samples));
  for (const StreamedCrops& set : samples.streams) add(set.hands->known_joints());
  std::vector<Landmark> unknown;
  for (std::size_t j = 0; j < known.size(); ++j) {
    if (!known[j]) unknown.push_back(convention.landmarks[j]);
  }
  return unknown;
}

}  // namespace knuckle
