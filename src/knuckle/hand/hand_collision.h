// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "knuckle/core/pose.h"

namespace knuckle {

/// How deep digits run into one another or into the palm, at the worst place [mm]; 0 where they do not. Bones
/// are capsules as thick as an adult's in proportion to the palm; what is jointed, and the sides of
/// neighbouring fingers at their roots, does not count.
double worst_penetration_mm(const std::array<Point3, kSupersetSize>& landmarks);

}  // namespace knuckle
