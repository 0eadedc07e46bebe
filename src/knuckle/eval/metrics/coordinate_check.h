// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "knuckle/eval/metrics/joint_errors.h"

namespace knuckle {

/// Coordinates in which a file's numbers lie far nearer to the truth than in those that it is read in.
struct LikelyCoordinates {
  PoseCoordinates coordinates;
  double median_mm = kNaN;          ///< 3D error of a joint in these
  double median_as_read_mm = kNaN;  ///< as it is read: infinite where most joints are behind the camera
};

/// Looks whether predictions are in another format, other axes or another unit than they are read in: people
/// mix them up, and the errors alone do not say so. Nothing where the numbers fit as they are read, or no
/// usual format fits them clearly better (a quarter of the error). Looks at 100 frames at most.
std::optional<LikelyCoordinates> likely_coordinates(const Truth& truth, const PoseNumbers& numbers,
                                                    PixelOrigin origin = PixelOrigin::centre);

}  // namespace knuckle
