// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/prepare/network_samples.h"
#include "knuckle/training/network_training_config.h"
#include "knuckle/training/sample_views.h"
#include "knuckle/training/streamed_views.h"

namespace knuckle {

/// The samples of one set of a configuration.
struct SetSamples {
  NetworkSamples hands;
  std::optional<NetworkSamples> things;
  double weight = 1.0;

  /// Lives as long as this.
  TrainingCrops crops() const { return {hands.samples, things ? &things->samples : nullptr, weight}; }
};

/// All samples of a configuration.
struct ConfiguredSamples {
  std::vector<SetSamples> sets;  ///< in the order of the configuration's sources
  NetworkSamples validation;
  std::vector<StreamedCrops> streams = {};  ///< in place of `sets` where they are not in memory

  std::vector<TrainingCrops> crops() const;
  /// What became of the frames of all sets.
  SampleFrames frames() const;
};

/// How samples are cut out of a part of a set, all of whose frames are taken where `most` stays 0.
SampleOptions sample_options(const NetworkTrainingConfig& config, const TrainingSource& source,
                             Holdout::Part part);

/// Opens each source and looks at its labels' names, before anything is rendered or cut out. Throws an Error
/// that names the source that has no truth, or no landmark that the network learns, and one where the samples
/// take more memory than they may, which streamed ones do not.
void check_sources(const NetworkTrainingConfig& config);

/// Makes the samples, or takes them from the folder `cache` (SampleCache; empty: none). Of each source at
/// most `most_of_each` frames, evenly spread, where that is not 0. Throws an Error that names a source of
/// which no frame can be used.
ConfiguredSamples configured_samples(const NetworkTrainingConfig& config, const std::filesystem::path& cache,
                                     std::int64_t most_of_each = 0);

/// The same for a training that streams them: validation alone is in memory. Without a folder samples are cut
/// out each time that they are needed. `config` has to live as long.
ConfiguredSamples streamed_samples(const NetworkTrainingConfig& config, const std::filesystem::path& cache);

/// How they are read, so that with the samples of the validation no more memory is taken than may be. Throws
/// an Error where that is not enough for two batches.
StreamingOptions streaming_options(const NetworkTrainingConfig& config, const CubeSamples& validation);

/// Landmarks of the network's convention that no sample of any set knows: nothing of them is learned. In the
/// convention's order.
std::vector<Landmark> unknown_landmarks(const NetworkTrainingConfig& config,
                                        const ConfiguredSamples& samples);

}  // namespace knuckle
