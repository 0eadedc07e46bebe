// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/prepare/train_pose_forest.h"

namespace knuckle::testing {

inline constexpr int kTestPatchSize = 12;

/// A made-up hand: a plane that slants along both axes, and joints that follow from the slants.
inline std::pair<HandPatch, std::vector<PatchPoint>> made_up_hand(std::uint64_t id,
                                                                  const Convention& convention) {
  Random random(11, id);
  const double slant_u = random.uniform(-1.0, 1.0);
  const double slant_v = random.uniform(-1.0, 1.0);
  HandPatch patch;
  patch.pixels = Image<float>(kTestPatchSize, kTestPatchSize);
  for (int v = 0; v < kTestPatchSize; ++v) {
    for (int u = 0; u < kTestPatchSize; ++u) {
      patch.pixels(u, v) =
          static_cast<float>((slant_u * u + slant_v * v) / kTestPatchSize + 0.01 * random.uniform());
    }
  }
  std::vector<PatchPoint> joints;
  for (std::size_t i = 0; i < convention.landmarks.size(); ++i) {
    joints.push_back({slant_u, slant_v, slant_u + 0.1 * static_cast<double>(i)});
  }
  return {patch, joints};
}

inline PoseTrainingSet made_up_set(std::int64_t count, const Convention& convention) {
  PoseTrainingSet set(count, convention, {.size_px = kTestPatchSize, .mean = {}, .whitening = {}});
  for (std::int64_t i = 0; i < count; ++i) {
    const auto [patch, joints] = made_up_hand(static_cast<std::uint64_t>(i), convention);
    set.set(i, patch, joints);
  }
  return set;
}

inline PoseForestModel made_up_model(const Convention& convention) {
  PoseForestTrainingOptions options;
  options.forest.trees = 4;
  options.forest.tree.splits_per_node = 300;
  options.forest.tree.min_leaf_samples = 1;
  return train_pose_forest(made_up_set(600, convention), options);
}

}  // namespace knuckle::testing
