// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/core/image.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// What a sensor gives no depth for.
struct DropOutOptions {
  double grazing_deg = 90.0;  ///< surfaces seen at a larger angle to their normal return too little light;
                              ///< 90: none do, [0, 90] [degree]
  double near_mm = 0.0;       ///< nothing nearer is measured, [0, 10000] [mm]
  double range_mm = 0.0;      ///< nothing beyond is measured; 0: no limit, [0, 10000] [mm]
  double hole_share = 0.0;    ///< part of the other pixels that is lost at random, [0, 1]

  void visit(OptionVisitor& visitor);
};

/// `depth_mm` without those. `cosines` (of the angle to the surface's normal) may be empty: all surfaces face
/// the camera.
Image<float> with_drop_outs(Image<float> depth_mm, const Image<float>& cosines, const DropOutOptions& options,
                            std::uint64_t seed);

}  // namespace knuckle
