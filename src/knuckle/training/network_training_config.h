// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "knuckle/pipeline/hand_finder.h"
#include "knuckle/prepare/inputs.h"
#include "knuckle/prepare/network_samples.h"
#include "knuckle/prepare/training_source.h"
#include "knuckle/training/network_training.h"

namespace knuckle {

/// Which frames of the sources become samples: the `[samples]` table.
struct NetworkSampleOptions {
  int most = 0;             ///< Frames of each `source` used at most, evenly spread, [0, 1e9]; 0: all
  int most_validation = 0;  ///< The same of `validation`
  int crop_px = 144;        ///< Size that is kept of each hand, so that views can turn and shift, [2, 4096]
  int most_things = 0;      ///< Frames of each `source` that things like hands are cut out of; 0: none
  std::string centre = "segmentation";  ///< segmentation | joints: what a hand is cut out around
  double memory_gb = 8.0;               ///< More than that is an error, (0, 10000]
  /// Sets that are larger than memory: samples are read from `--cache`, without one cut out anew each time;
  /// `memory_gb` bounds what is in memory.
  bool stream = false;
  int stream_window = 65536;  ///< Streamed samples of a set that are shuffled together, [1, 1e9]

  void visit(OptionVisitor& visitor);
};

/// A configuration of `train network`: where frames come from, how hands are cut out of them, what is trained
/// and how.
///
///     source = "synthetic:../manifests/train_network.toml"  # any source; a relative path starts here.
///     Several
///                                   # sets: a table [[source]] for each, see TrainingSource
///     validation = "synthetic:../manifests/validate_network.toml"  # frames that are not trained on; without
///                                   # this line what `holdout` keeps of the sets
///     initial = "../models/dense.pt"  # begin with its weights; without this line with random ones
///     detector = "../models/detector.pt"  # finds things that look like hands, for most_things
///     start = "nearest"             # nearest | truth: where segmentation starts
///     [hand]                        # as in a pipeline file
///     [segmentation]
///     [patch]
///     [samples]                     # NetworkSampleOptions
///     [network]                     # NetworkOptions
///     [augmentation]                # AugmentationOptions
///     [training]                    # NetworkTrainingOptions
struct NetworkTrainingConfig {
  std::vector<TrainingSource> sources;
  std::string validation;         ///< empty: what the sources hold out
  std::filesystem::path initial;  ///< empty: random weights
  std::filesystem::path detector;
  Start start = Start::nearest;
  HandFinder finder;
  Inputs segmentation;  ///< what `finder` was made from
  NetworkSampleOptions samples;
  NetworkOptions network;
  std::optional<LandmarkDefinition> definition;  ///< of landmarks that are none of the 22
  AugmentationOptions augmentation;
  NetworkTrainingOptions training;
  std::string resolved_options;  ///< the file with all defaults filled in

  /// Throws an Error that names file, line and key where the file is wrong.
  static NetworkTrainingConfig load(const std::filesystem::path& path);
};

/// What a training tells beside its model.
struct NetworkTrainingResult {
  std::vector<TrainingMetrics> metrics;
  SampleFrames frames;  ///< of all sets
  SampleFrames validation_frames;
};

/// Is told, before a training begins, the landmarks of the network that no sample of any set knows.
using TakeUnknownLandmarks = std::function<void(const std::vector<Landmark>&)>;

/// Cuts samples out of all sources, or takes them from the folder `cache` (SampleCache; empty: none), and
/// trains. `unknown` is called where there are landmarks of which nothing can be learned; may be empty.
/// Throws an Error where a source has no truth or no landmark that the network learns, no frame of it can be
/// used, or the samples take more memory than they may.
NetworkTrainingResult run_network_training(const NetworkTrainingConfig& config, const NetworkTrainingRun& run,
                                           const std::filesystem::path& cache = {},
                                           const TakeUnknownLandmarks& unknown = {});

}  // namespace knuckle
