// SPDX-License-Identifier: Apache-2.0
// What a stopped training of a forest has left, for one that goes on. (A network's training keeps LibTorch's
// archives, which this preset has no library for: scripts/damage_files.py damages those.)
#include "fuzz_target.h"

#include <array>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/forest/forest_trainer.h"
#include "knuckle/forest/pixel_forest_trainer.h"

namespace knuckle::fuzz {
namespace {

constexpr int kFeatures = 4;

TrainingSamples few_samples() {
  TrainingSamples samples(12, kFeatures, 2);
  for (int i = 0; i < 12; ++i) {
    const auto x = static_cast<float>(i);
    const std::array<float, kFeatures> features{x, 1.0F - x, 0.5F * x, static_cast<float>(i % 3)};
    samples.set(i, features, std::array{2.0F * x, static_cast<float>(i % 2)});
  }
  return samples;
}

constexpr TreeOptions kSmallTrees{.max_depth = 3, .splits_per_node = 8, .min_leaf_samples = 1};

/// Predicts something, so that whatever a node reads is read.
void train_pose_forest(const TrainingRun& run) {
  static const TrainingSamples samples = few_samples();
  const RegressionForest forest =
      train_regression_forest(samples, {.trees = 2, .tree = kSmallTrees, .leaf_bits = 32}, run);
  (void)forest.predict(std::array<float, kFeatures>{1.0F, 2.0F, 3.0F, 4.0F});
}

constexpr Camera kCamera{CameraModel::projective, 12, 9, 20.0, 20.0, 6.0, 4.0, {}};

PixelSamples few_pixels() {
  Image<float> depth(12, 9, 600.0F);
  depth(3, 4) = 400.0F;
  PixelSamples samples(1);
  samples.set(0, depth, kCamera, std::vector<LabelledPixel>{{3, 4, 1}, {4, 4, 1}, {9, 2, 0}, {1, 1, 0}});
  return samples;
}

void train_segmentation_forest(const TrainingRun& run) {
  static const PixelSamples samples = few_pixels();
  const PixelForest forest =
      train_pixel_forest(samples, {.trees = 2, .tree = kSmallTrees, .offsets = {}}, run);
  (void)forest.above(Image<float>(12, 9, 600.0F), kCamera, 0.5F);
}

}  // namespace

/// '0' and '1': the trees of a pose forest, and the splits of the one that was being grown; '2' and '3':
/// those of a segmentation forest.
void run_forest_checkpoint(Bytes bytes) {
  const auto [which, content] = selected(bytes, 4);
  const std::string model = with_sum(content);
  const FuzzFile file(as_bytes_of(model), which % 2 == 0 ? ".checkpoint" : ".checkpoint.tree");
  std::filesystem::path checkpoint = file.path();
  if (which % 2 == 1) checkpoint.replace_extension();
  const TrainingRun run{.checkpoint = checkpoint, .checkpoint_interval_s = 1e9};
  try {
    which < 2 ? train_pose_forest(run) : train_segmentation_forest(run);
  } catch (...) {
    remove_checkpoint(checkpoint);
    throw;
  }
}

}  // namespace knuckle::fuzz
