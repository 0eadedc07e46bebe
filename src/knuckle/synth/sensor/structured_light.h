// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// A camera that finds depth by triangulation with a projector beside it: z = f b / d, where d is the
/// disparity between camera and projector in pixels (Khoshelham and Oude Elberink 2012, with their
/// reference plane at infinity).
struct StructuredLightOptions {
  double baseline_mm = 0.0;   ///< of the projector from the camera along x; negative: on its left;
                              ///< 0: no structured light, [-1000, 1000] [mm]
  double disparity_px = 0.0;  ///< step that disparities are rounded to; 0: not rounded, [0, 10] [px]
  bool shadows = true;        ///< what the projector does not reach is not measured

  void visit(OptionVisitor& visitor);
};

/// `depth_mm` without what lies in the projector's shadow. A shadow falls on the side away from the projector
/// and is f b (1 / z_near - 1 / z_far) px wide. Each row is one plane of light: its points are drawn into the
/// projector's column z-buffer, and what lies more than 2 px of disparity behind the nearest point there is
/// in the shadow. What the camera does not see casts none. Neighbours whose depths differ by at most
/// `jump_mm` are one surface without a gap.
Image<float> without_shadows(Image<float> depth_mm, const Camera& camera,
                             const StructuredLightOptions& options, double jump_mm);

/// `depth_mm` where f |b| / z is a whole number of steps; 0 where that number is 0. Depth steps grow with the
/// square of the range: about z^2 disparity_px / (f |b|).
Image<float> with_rounded_disparity(Image<float> depth_mm, const Camera& camera,
                                    const StructuredLightOptions& options);

}  // namespace knuckle
