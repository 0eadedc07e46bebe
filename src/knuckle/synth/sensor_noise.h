// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/core/image.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// What a sensor makes of exact depths.
struct SensorOptions {
  double sigma_mm = 3.0;         ///< deviation of Gaussian noise, as in the paper, [0, 100] [mm]
  double quantisation_mm = 1.0;  ///< step that depths are rounded to; 0 = not rounded, [0, 100] [mm]
  double background_mm = 0.0;    ///< a wall behind all; 0 = none, as in the paper, [0, 10000] [mm]
  double range_mm = 0.0;         ///< nothing beyond is measured; 0 = no limit, [0, 10000] [mm]

  void visit(OptionVisitor& visitor);
};

/// The depth image that the sensor gives [mm]; 0 stays 'no measurement' (or becomes the wall). Each pixel has
/// its own random number, made from `seed` and its place: the same bits in any order of work.
Image<float> measured(const Image<float>& depth_mm, const SensorOptions& options, std::uint64_t seed);

}  // namespace knuckle
