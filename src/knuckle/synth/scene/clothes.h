// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/hand/skinning.h"
#include "knuckle/synth/scene/scene_mesh.h"

namespace knuckle {

/// Where a person's skin lies along the right arm: for each vertex of hand and arm the way from the wrist
/// towards the elbow, at rest [mm]; below 0 in the hand.
std::vector<float> way_along_arm(const ShapedBody& person);

/// A hand and its arm as they are in the picture.
struct ArmSkin {
  std::span<const Eigen::Vector3f> vertices;           ///< in place [mm]
  std::span<const std::array<std::int32_t, 3>> faces;  ///< counter-clockwise from outside
  std::span<const Eigen::Vector3f> rest;               ///< the vertices at rest [mm]
  std::span<const float> along_mm;                     ///< `way_along_arm`
};

/// What is worn around a part of the arm, like a hose that widens the skin.
struct Hose {
  float from_mm = 0.0f;                       ///< its end towards the hand, along the arm
  float to_mm = 1000.0f;                      ///< its other end
  float gap_mm = 3.0f;                        ///< above the skin
  float flare_mm = 0.0f;                      ///< more gap at the hand's end
  float fold_mm = 0.0f;                       ///< height of folds
  std::array<Eigen::Vector3f, 3> folds = {};  ///< directions of folds at rest, 2 pi / wavelength [1 / mm]
};

/// A long or short sleeve.
Hose sampled_sleeve(Random& random);
/// A bracelet, the band of a watch, a cuff.
Hose sampled_band(Random& random);

/// The hose's outside, and its end towards the hand; faces are the person's.
SceneMesh mesh_of(const Hose& hose, const ArmSkin& skin);

}  // namespace knuckle
