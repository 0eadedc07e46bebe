// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "knuckle/segment/detector/detector_options.h"

namespace knuckle {

/// How far each cell stands out from what surrounds it: from the mean inverse depth of the measured cells in
/// a square around it, 7 cells wide in the first plane and 25 in the second, as millimetres x before it,
/// flattened to x / (u + |x|), in (-1, 1), where u is 10 and 40 mm. 0 where nothing was measured. A plane has
/// none, however it is slanted: in inverse depth it is a linear ramp.
///
/// A hand that lies on a table is 20 mm before it, which is 3 % of its inverse depth at 600 mm, and less than
/// a step of a number of 16 bits at a third of a metre.
///
/// `inverse_depth`: height x width [1/m], finite, at least 0. `reliefs`: kReliefInputs x height x width.
void write_reliefs(const DetectorOptions& options, std::span<const float> inverse_depth,
                   std::span<float> reliefs);

}  // namespace knuckle
