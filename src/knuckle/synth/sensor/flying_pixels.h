// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "knuckle/core/image.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// Flying pixels of a time-of-flight camera: a pixel at a depth edge collects light of both surfaces and
/// measures a depth between them (Foix, Alenya and Torras 2011; Sarbolandi, Lefloch and Kolb 2015). A pixel
/// sees a stretch of `flying_px` around its centre, and the edge lies anywhere between the centres of the two
/// pixels, so of the pixels along an edge the part flying_px / 2 is mixed.
struct FlyingPixelOptions {
  double flying_px = 0.0;  ///< what a pixel sees across an edge, [0, 2] [px]; 1: its own area; 0: off

  void visit(OptionVisitor& visitor);
};

/// `depth_mm` where the pixels of `edges` are mixed with the neighbour (of four) whose depth differs most.
/// With t uniform in [0, 1) from the pixel's own random numbers, the neighbour's share is s = 1/2 - t /
/// flying_px (no mixture where that is not above 0), and as the light that comes back falls with the square
/// of the depth,
///
///     z = (z_1 (1 - s) / z_1^2 + z_2 s / z_2^2) / ((1 - s) / z_1^2 + s / z_2^2).
///
/// Phases are taken as proportional to depths and amplitudes, which holds for surfaces much less than the
/// range of a modulation period (some metres) apart. A neighbour that sees nothing gives no light.
Image<float> with_flying_pixels(const Image<float>& depth_mm, std::span<const std::int32_t> edges,
                                const FlyingPixelOptions& options, std::uint64_t seed);

}  // namespace knuckle
