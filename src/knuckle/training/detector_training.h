// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/prepare/detector_augmentation.h"
#include "knuckle/prepare/detector_samples.h"
#include "knuckle/training/network_training.h"

namespace knuckle {

/// Numbers of a detector's validation, over frames that are seen as they are, with the default
/// DetectionOptions. A hand is found where a detection that is no other hand's lies within 40 mm of its
/// centre.
enum DetectorScore : std::size_t {
  kRecall,          ///< share of the hands that were found
  kFalsePositives,  ///< detections per frame that are no hand's
  kSideAccuracy,    ///< share of the hands found whose side is right; NaN where none is known
  kCentreMm,        ///< mean distance of the hands found [mm]; NaN where none was
  kMistakes,  ///< hands missed, found that are none, and of the wrong side, per hand; the best has the least
  kDetectorScores
};
/// Their names as metrics.csv has them, in their order.
inline constexpr std::array<std::string_view, kDetectorScores> kDetectorScoreNames{
    "recall_40mm", "false_positives_per_frame", "side_accuracy", "centre_mm", "mistakes_per_hand"};

/// Which frames of the sources a detector learns from: the `[samples]` table.
struct DetectorSampleOptions {
  int most = 0;             ///< Frames of each source used at most, evenly spread, [0, 1e9]; 0: all
  int most_validation = 0;  ///< The same of `validation`
  double memory_gb = 8.0;   ///< More than that is an error, (0, 10000]
  /// Frames are read each time that they are needed, and kept nowhere; those of the validation are in memory.
  bool stream = false;

  void visit(OptionVisitor& visitor);
};

/// A configuration of `train network` whose `[network]` has the architecture "detector".
///
///     source = "synthetic:../manifests/train_network.toml"  # with truth; a relative path starts here;
///                                   # several are tables [[source]], DetectorSource: each frame counts once
///     validation = "synthetic:../manifests/validate_network.toml"  # frames that are not trained on
///     initial = "../models/detector.pt"  # begin with its weights; without this line with random ones
///     [samples]                     # DetectorSampleOptions
///     [network]                     # architecture = "detector", and DetectorOptions
///     [augmentation]                # DetectorAugmentation
///     [training]                    # NetworkTrainingOptions
struct DetectorTrainingConfig {
  std::vector<DetectorSource> sources;
  DetectorSource validation;
  std::filesystem::path initial;  ///< empty: random weights
  DetectorSampleOptions samples;
  DetectorOptions network;
  DetectorAugmentation augmentation;
  NetworkTrainingOptions training;
  std::string resolved_options;  ///< the file with all defaults filled in

  /// Throws an Error that names file, line and key where the file is wrong.
  static DetectorTrainingConfig load(const std::filesystem::path& path);
};

/// The architecture's name in configurations.
inline constexpr std::string_view kDetectorArchitecture = "detector";
/// Whether a configuration is a detector's. Throws an Error where there is no such file.
bool is_of_detector(const std::filesystem::path& config);

/// Trains a detector; throws as `train_network` does.
std::vector<TrainingMetrics> train_detector(const DetectorOptions& network,
                                            const NetworkTrainingOptions& options,
                                            const DetectorAugmentation& augmentation,
                                            const DetectorSamples& training,
                                            const DetectorSamples& validation, const NetworkTrainingRun& run);

/// The same of frames that are not in memory, of which `most_at_once` are read together and twice as many
/// held. The model has the same bytes.
std::vector<TrainingMetrics> train_detector(const DetectorOptions& network,
                                            const NetworkTrainingOptions& options,
                                            const DetectorAugmentation& augmentation,
                                            const DetectorFrames& training, std::int64_t most_at_once,
                                            const DetectorSamples& validation, const NetworkTrainingRun& run);

/// Makes the samples of a configuration and trains. Throws an Error where a source has no truth or the
/// samples take more memory than they may.
std::vector<TrainingMetrics> run_detector_training(const DetectorTrainingConfig& config,
                                                   const NetworkTrainingRun& run);

}  // namespace knuckle
