// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "knuckle/core/image.h"

namespace knuckle {

/// The 8-connected components of the pixels that are not 0, each as indices row * width + column, ascending;
/// in the order of their first pixels.
std::vector<std::vector<std::int32_t>> components_of(const Image<std::uint8_t>& mask);

}  // namespace knuckle
