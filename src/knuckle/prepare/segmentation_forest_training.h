// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "knuckle/core/worker_group.h"
#include "knuckle/forest/pixel_forest_trainer.h"
#include "knuckle/pipeline/hand_finder.h"

namespace knuckle {

/// Which frames and which of their pixels a segmentation forest is trained on.
struct PixelSamplingOptions {
  double share = 1.0;          ///< Part of the source's frames, drawn at random, (0, 1]; the paper's is 0.2
  int hand_pixels = 120;       ///< Drawn in each frame, without replacement (Tompson et al. 2014), [1, 10^5]
  int background_pixels = 60;  ///< Of those that were measured and are no hand, [1, 10^5]
  /// Points that near to the true wrist count as hand, whatever the mask says: for sets whose masks reach
  /// over the wrist; 0: the mask alone counts, [0, 200] [mm]
  double wrist_mm = 0.0;
  std::uint64_t seed = 1;

  void visit(OptionVisitor& visitor);
};

/// A configuration of `train segmentation-forest`.
///
///     source = "synthetic:../manifests/train_segmentation.toml"   # any source with masks; relative to this
///     file [hand]                        # side = "left": frames are mirrored first [pixels] #
///     PixelSamplingOptions [forest]                      # PixelForestOptions
struct SegmentationForestTrainingConfig {
  std::string source;
  HandOptions hand;
  PixelSamplingOptions pixels;
  PixelForestOptions forest;
  std::string resolved_options;  ///< the file with all defaults filled in

  /// Throws an Error that names file, line and key where the file is wrong.
  static SegmentationForestTrainingConfig load(const std::filesystem::path& path);
};

/// A trained forest, and what it was trained on.
struct SegmentationForestTraining {
  PixelForest forest;
  std::int64_t frames = 0;
  std::int64_t samples = 0;
  std::size_t sample_bytes = 0;  ///< images and pixels
  double collection_s = 0.0;
};

/// Draws pixels of the frames and trains a forest on them. With a `checkpoint`, a training that was stopped
/// goes on where it was. Throws an Error where a frame has no mask (or no wrist, where
/// wrist_mm asks for one), no pixel of a class was found, or the
/// samples outgrow [forest] memory_gb (it says how many frames would fit).
SegmentationForestTraining run_training(const SegmentationForestTrainingConfig& config,
                                        const TrainingRun& run);

/// The same by several workers, each of which draws pixels of a part of the frames: the forest has the same
/// bits. Worker 0 alone has a checkpoint, and gets what came out; sample_bytes are its own.
std::optional<SegmentationForestTraining> run_training(const SegmentationForestTrainingConfig& config,
                                                       const TrainingRun& run, WorkerGroup& workers);

}  // namespace knuckle
