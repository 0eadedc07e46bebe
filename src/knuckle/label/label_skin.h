// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// How deep the landmark lies below the skin that is seen before it [mm], of a hand whose palm is that long:
/// medians of the generator's people. 0 outside of the 22.
double depth_below_skin_mm(Landmark landmark, double palm_mm);

/// Where the skin of a hand may be [mm].
struct SkinDepths {
  double near_mm = 0.0;
  double far_mm = 1e9;
};

/// The depths at which a hand's skin may be seen whose landmarks lie there; any where fewer than three are
/// known.
SkinDepths skin_depths(const std::vector<ImagePoint>& landmarks);

/// The depth of the skin that a person shows on a pixel [mm]: of what was measured around it, the nearest to
/// the pixel that may be skin, so that one who points beside a finger does not get the wall behind it.
/// Nothing where none was within 6 px.
std::optional<double> skin_depth_at(const Frame& frame, double u, double v, const SkinDepths& depths);

/// Where a landmark lies that a person shows on a pixel: as deep as the skin there (`skin_depth_at`), and
/// what lies between skin and joint. Without a measurement, `depth_mm` is kept. Missing where neither is
/// known.
ImagePoint placed_on_pixel(const Frame& frame, double u, double v, Landmark landmark, double palm_mm,
                           double depth_mm, const SkinDepths& depths = {});

/// The depth of a landmark that was shown on a pixel [mm]: between what was measured there and where the hand
/// model has it, which knows the rest of the hand. The farther both are apart, the less the measurement
/// counts (Geman and McClure 1985): another finger may lie before the joint. Never more than 20 mm from the
/// measurement: a person calls the landmark visible, so that its skin is what was measured, and a model that
/// lies elsewhere is wrong.
double settled_depth_mm(double measured_mm, double fitted_mm);

}  // namespace knuckle
