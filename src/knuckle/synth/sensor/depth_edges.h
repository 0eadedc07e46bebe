// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "knuckle/core/image.h"

namespace knuckle {

/// The pixels (row * width + column, ascending) on either side of a depth edge: where one of the four
/// neighbours lies nearer or farther by more than `jump_mm`. A pixel that sees nothing has depth 0.
std::vector<std::int32_t> edge_pixels(const Image<float>& depth_mm, double jump_mm);

}  // namespace knuckle
