// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace knuckle {

/// One degree [rad]: `30.0 * kDegree` is an angle of 30 degrees.
inline constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace knuckle
