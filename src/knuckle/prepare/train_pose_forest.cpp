// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/train_pose_forest.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"

namespace knuckle {

namespace {

bool is_missing(const PatchPoint& point) {
  return !(std::isfinite(point.u) && std::isfinite(point.v) && std::isfinite(point.d));
}

std::vector<double> target_weights(const Convention& convention, const PoseForestTrainingOptions& options) {
  std::vector<double> weights;
  for (std::size_t joint = 0; joint < convention.landmarks.size(); ++joint) {
    weights.insert(weights.end(), {1.0, 1.0, options.depth_weight});
  }
  return weights;
}

}  // namespace

PoseTrainingSet::PoseTrainingSet(std::int64_t count, const Convention& convention, PatchStatistics statistics,
                                 std::int64_t spare)
    : convention_(convention),
      statistics_(std::move(statistics)),
      samples_(count, statistics_.size_px * statistics_.size_px,
               static_cast<int>(convention.landmarks.size()) * kTargetsPerLandmark, {}, spare) {}

PoseTrainingSet::Kept PoseTrainingSet::set(std::int64_t index, const HandPatch& patch,
                                           std::span<const PatchPoint> joints) {
  if (patch.pixels.width() != statistics_.size_px || patch.pixels.height() != statistics_.size_px) {
    fail("training sample {}: a patch of {} x {}, expected {} x {}", index, patch.pixels.width(),
         patch.pixels.height(), statistics_.size_px, statistics_.size_px);
  }
  if (joints.size() != convention_.landmarks.size()) {
    fail("training sample {}: {} joints, expected the {} of {}", index, joints.size(),
         convention_.landmarks.size(), convention_.name);
  }
  if (std::ranges::any_of(joints, is_missing)) return Kept::joint_missing;
  std::vector<float> targets;
  targets.reserve(joints.size() * kTargetsPerLandmark);
  for (const PatchPoint& joint : joints) {
    targets.push_back(static_cast<float>(joint.u));
    targets.push_back(static_cast<float>(joint.v));
    targets.push_back(static_cast<float>(joint.d));
  }
  samples_.set(index, patch.pixels.pixels(), targets);
  return Kept::yes;
}

void check_training_memory(std::int64_t count, const Convention& convention, int patch_size_px,
                           const PoseForestTrainingOptions& options) {
  const int targets = static_cast<int>(convention.landmarks.size()) * kTargetsPerLandmark;
  check_training_memory(count, patch_size_px * patch_size_px, targets, options.forest);
}

PoseForestModel train_pose_forest(const PoseTrainingSet& set, const PoseForestTrainingOptions& options,
                                  const TrainingRun& run) {
  check_options(options, "pose forest training");
  return {
      set.convention(), set.statistics(),
      train_regression_forest(set.samples(), options.forest, run, target_weights(set.convention(), options))};
}

std::optional<PoseForestModel> train_pose_forest(WorkerGroup& workers, PoseTrainingSet& set,
                                                 std::int64_t first_number,
                                                 const PoseForestTrainingOptions& options,
                                                 const TrainingRun& run) {
  check_options(options, "pose forest training");
  auto forest = train_regression_forest(workers, set.samples(), first_number, options.forest, run,
                                        target_weights(set.convention(), options));
  if (!forest) return std::nullopt;
  return PoseForestModel{set.convention(), set.statistics(), std::move(*forest)};
}

}  // namespace knuckle
