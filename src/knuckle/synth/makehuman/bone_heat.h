// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace knuckle {

/// A bone as the straight line between its joints [mm].
struct BoneSegment {
  Eigen::Vector3d head;
  Eigen::Vector3d tail;
};

/// Skin weights by bone heat (Baran and Popovic, "Automatic rigging and animation of 3D characters", 2007,
/// sec. 4): every vertex is heated by its nearest bone and the heat spreads over the skin, (-Laplace + H) w =
/// H p. The skin must surround its bones such that the nearest bone is its own: fingers spread, as at rest.
///
/// Gives N x B weights in [0, 1] up to rounding; each row sums to 1. `heat` [> 0] is how strongly bones hold:
/// the transition between two bones is about distance to the bone / sqrt(heat) wide. Vertices must all have a
/// face.
Eigen::MatrixXd bone_heat_weights(std::span<const Eigen::Vector3d> vertices_mm,
                                  std::span<const std::array<std::int32_t, 3>> faces,
                                  std::span<const BoneSegment> bones, double heat);

}  // namespace knuckle
