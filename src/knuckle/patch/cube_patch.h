// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "knuckle/core/frame.h"
#include "knuckle/patch/hand_patch.h"

namespace knuckle {

/// A cube in front of the camera that a patch shows.
struct Cube {
  int size_px = 96;        ///< width and height of the patch, at least 2 [px]
  double side_mm = 250.0;  ///< above 0 [mm]
};

/// The value of pixels without a measurement in the cube: its far end.
inline constexpr float kCubeBackground = 1.0f;

/// Where the patch of a cube around `centre` lies. The cube's front is projected at the centre's depth, so
/// that a hand has the same size at any distance; d = -1 and 1 are the cube's near and far end.
PatchGeometry cube_geometry(const Camera& camera, const ImagePoint& centre, const Cube& cube);

/// Cuts a metric cube out of a frame, as DeepPrior++ (Oberweger and Lepetit 2017) and AWR (Huang et al. 2020)
/// do: each of the patch's pixels is the image's nearest one, its depth from the centre in halves of the
/// cube's side. Pixels outside of the cube or of the image, and those not measured, are background, +1.
///
/// Nothing where no measured pixel falls into the cube, or the centre is missing or not in front of the
/// camera.
std::optional<HandPatch> extract_cube(const Frame& frame, const ImagePoint& centre, const Cube& cube);

}  // namespace knuckle
