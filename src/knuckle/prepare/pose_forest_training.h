// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "knuckle/core/worker_group.h"
#include "knuckle/patch/patch_extractor.h"
#include "knuckle/pipeline/hand_finder.h"
#include "knuckle/pipeline/start.h"
#include "knuckle/prepare/train_pose_forest.h"

namespace knuckle {

/// A configuration of `train pose-forest`: where frames come from, how hands are cut out of them, and how the
/// forest is grown.
///
///     source = "synthetic:../manifests/train_small.toml"   # any source; a relative path starts at this file
///     convention = "icg20"          # landmarks to predict
///     start = "truth"               # nearest | truth: where segmentation starts
///     [hand]                        # as in a pipeline file
///     [segmentation]
///     [patch]
///     [forest]                      # PoseForestTrainingOptions
struct PoseForestTrainingConfig {
  std::string source;
  Convention convention = superset_convention();
  Start start = Start::truth;
  HandFinder finder;
  PatchOptions patch;
  PoseForestTrainingOptions forest;
  std::string resolved_options;  ///< the file with all defaults filled in

  /// Throws an Error that names file, line and key where the file is wrong.
  static PoseForestTrainingConfig load(const std::filesystem::path& path);
};

/// What became of the frames of a training source.
struct TrainingFrames {
  std::int64_t total = 0;
  std::int64_t without_hand = 0;         ///< segmentation found none
  std::int64_t with_missing_joints = 0;  ///< a joint of the convention is not labelled
  std::int64_t used() const { return total - without_hand - with_missing_joints; }
};

/// A trained model, and what became of the frames.
struct PoseForestTraining {
  PoseForestModel model;
  TrainingFrames frames;
};

/// Cuts the hand out of every frame and trains a forest on the patches. With a checkpoint, a training that
/// was stopped goes on where it was. Throws an Error where the source has no truth, or no frame
/// of it can be used.
PoseForestTraining run_training(const PoseForestTrainingConfig& config, const TrainingRun& run);

/// The same by several workers, each of which cuts out a part of the frames: the model has the same bits.
/// Worker 0 alone has a checkpoint, and gets what came out.
std::optional<PoseForestTraining> run_training(const PoseForestTrainingConfig& config, const TrainingRun& run,
                                               WorkerGroup& workers);

}  // namespace knuckle
