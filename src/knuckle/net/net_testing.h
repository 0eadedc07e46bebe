// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/net/network_options.h"
#include "knuckle/prepare/cube_samples.h"
#include "knuckle/prepare/cube_view.h"

namespace knuckle::testing {

inline constexpr Cube kTestCube{32, 200.0};
inline constexpr int kTestCropPx = 48;
inline constexpr int kDotRadius = 2;
inline constexpr int kTestJoints = 14;  // of nyu14
inline const Point3 kTestCentre{20.0, -10.0, 500.0};

/// A crop of a made-up hand: each joint is a square of 5 x 5 pixels at its own depth; the squares do not
/// touch.
struct MadeUpHand {
  HandPatch crop;
  std::vector<PatchPoint> joints;
};

inline MadeUpHand made_up_hand(std::uint64_t id) {
  constexpr int kCell = 7;
  constexpr int kFirst = 13;
  constexpr int kColumns = 4;
  constexpr double kHalf = 0.5 * (kTestCropPx - 1);
  Random random(5, id);
  MadeUpHand hand;
  hand.crop.pixels = Image<float>(kTestCropPx, kTestCropPx, kCubeBackground);
  for (int j = 0; j < kTestJoints; ++j) {
    const int column = kFirst + kCell * (j % kColumns) + static_cast<int>(random.below(3)) - 1;
    const int row = kFirst + kCell * (j / kColumns) + static_cast<int>(random.below(3)) - 1;
    const double d = random.uniform(-0.5, 0.5);
    hand.joints.push_back({(column - kHalf) / kHalf, (row - kHalf) / kHalf, d});
    for (int y = -kDotRadius; y <= kDotRadius; ++y) {
      for (int x = -kDotRadius; x <= kDotRadius; ++x) {
        hand.crop.pixels(column + x, row + y) = static_cast<float>(d);
      }
    }
  }
  return hand;
}

/// Samples whose joints lie `behind_mm` behind the surface.
inline CubeSamples made_up_samples(std::int64_t count, double behind_mm = 0.0) {
  CubeSamples samples(count, kTestJoints, kTestCube, kTestCropPx);
  for (std::int64_t i = 0; i < count; ++i) {
    MadeUpHand hand = made_up_hand(static_cast<std::uint64_t>(i));
    for (PatchPoint& joint : hand.joints) joint.d += behind_mm / (0.5 * samples.crop().side_mm);
    samples.set(i, hand.crop, hand.joints, kTestCentre);
  }
  samples.finish();
  return samples;
}

/// Every sample as it is.
inline AugmentationOptions no_augmentation() {
  return {.rotation_deg = 0,
          .shift_mm = 0,
          .recentred_share = 0,
          .scale_spread = 0,
          .noise_mm = 0,
          .missing_share = 0,
          .erased_share = 0,
          .erased_mm = 0};
}

inline NetworkOptions small_network() {
  NetworkOptions options;
  options.convention = "nyu14";
  options.patch = {.size_px = kTestCube.size_px, .mode = "cube", .cube_mm = kTestCube.side_mm};
  options.dense = {.stem_channels = 8,
                   .quarter_channels = 16,
                   .eighth_channels = 16,
                   .sixteenth_channels = 16,
                   .head_channels = 32};
  options.paper = {.first_maps = 4, .second_maps = 8, .hidden_units = 64, .subspace_units = 16};
  return options;
}

}  // namespace knuckle::testing
