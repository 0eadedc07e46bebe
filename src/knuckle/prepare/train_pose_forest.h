// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "knuckle/core/options.h"
#include "knuckle/core/worker_group.h"
#include "knuckle/estimate/pose_forest.h"
#include "knuckle/forest/forest_trainer.h"
#include "knuckle/forest/training_samples.h"

namespace knuckle {

/// Training of a pose forest; the defaults of the forest are the paper's.
struct PoseForestTrainingOptions {
  RegressionForestOptions forest;
  double depth_weight = kDepthWeight;  ///< in the scores of splits, [0, 100]

  void visit(OptionVisitor& visitor) {
    forest.visit(visitor);
    visitor.real("depth_weight", depth_weight, closed(0, 100));
  }
};

/// Patches and where their joints are, to train on. Patches are kept with 16 bits per pixel, in steps of
/// 1/1024 deviations (a fortieth of a millimetre for a usual hand): 18.4 kB for one of 96 x 96.
class PoseTrainingSet {
 public:
  /// Room for `count` samples. `statistics` are those of the patches that will be set. A mean patch changes
  /// nothing for a forest: its features are differences of pixels, and each split has a threshold of its own.
  /// Leave it empty. `spare`: samples that may come from other workers besides (TrainingSamples).
  PoseTrainingSet(std::int64_t count, const Convention& convention, PatchStatistics statistics,
                  std::int64_t spare = 0);

  /// Whether a sample takes part in the training.
  enum class Kept { yes, joint_missing };

  /// Sets sample `index`, each at most once; safe to call from many threads. `joints` are in patch
  /// coordinates, one per landmark. A sample of which a joint is missing (NaN) cannot be scored: it is left
  /// out, and the answer says so. Samples never set are left out as well. Throws an Error where a size is
  /// wrong or a pixel is not finite.
  Kept set(std::int64_t index, const HandPatch& patch, std::span<const PatchPoint> joints);

  std::int64_t kept_count() const { return samples_.set_count(); }
  const TrainingSamples& samples() const { return samples_; }
  TrainingSamples& samples() { return samples_; }
  const Convention& convention() const { return convention_; }
  const PatchStatistics& statistics() const { return statistics_; }

 private:
  Convention convention_;
  PatchStatistics statistics_;
  TrainingSamples samples_;
};

/// Throws an Error where `count` samples would take more memory than options.forest.memory_gb. Call it before
/// a set is made.
void check_training_memory(std::int64_t count, const Convention& convention, int patch_size_px,
                           const PoseForestTrainingOptions& options);

/// Trains on all samples kept. The forest depends on the samples and options only, not on threads or the
/// samples' order. With a checkpoint a training that was stopped goes on where it was. Throws an Error where
/// no sample was kept.
PoseForestModel train_pose_forest(const PoseTrainingSet& set, const PoseForestTrainingOptions& options,
                                  const TrainingRun& run = {});

/// Trains on the samples of all workers the forest that one process would train, bit by bit. `set` has this
/// worker's, which move between the workers; its sample 0 has the number `first_number` among all. Worker 0
/// alone has a checkpoint, and gets the forest.
std::optional<PoseForestModel> train_pose_forest(WorkerGroup& workers, PoseTrainingSet& set,
                                                 std::int64_t first_number,
                                                 const PoseForestTrainingOptions& options,
                                                 const TrainingRun& run = {});

}  // namespace knuckle
