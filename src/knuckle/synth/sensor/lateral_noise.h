// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/image.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// Lateral noise: the sensor places a surface's outline wrongly by a fraction of a pixel, which makes
/// outlines ragged. Nguyen, Izadi and Lovell 2012 measured about 0.8 px for the Kinect v1, growing little
/// with the angle.
struct LateralNoiseOptions {
  double lateral_px = 0.0;  ///< deviation in x and in y, [0, 2] [px]; 0: off

  void visit(OptionVisitor& visitor);
};

/// A pixel that shows what another pixel sees.
struct DisplacedPixel {
  std::int32_t pixel;
  std::int32_t source;  ///< row * width + column, as `pixel`
};

/// Where the pixels of `edges` look: aside by a normal number of pixels in x and in y, rounded, and not over
/// the image's border. Those that look straight are left out. Pixels that are not beside an edge are not
/// displaced: there it would be range noise.
std::vector<DisplacedPixel> displaced_pixels(std::span<const std::int32_t> edges, int width, int height,
                                             const LateralNoiseOptions& options, std::uint64_t seed);

/// `image` as seen with these displacements.
Image<float> displaced(const Image<float>& image, std::span<const DisplacedPixel> pixels);

}  // namespace knuckle
