// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "knuckle/core/box.h"
#include "knuckle/core/image.h"

namespace knuckle {

/// How a sensor's picture of a hand looks, for the comparison of synthetic with real frames. A value that
/// cannot be measured in a frame is NaN.
struct HandStatistics {
  double depth_mm = 0.0;          ///< mean depth of the hand
  double depth_spread_mm = 0.0;   ///< standard deviation of the hand's depths
  double valid_share = 0.0;       ///< measured pixels in the hand's box, in parts of the box
  double surface_noise_mm = 0.0;  ///< deviation of a pixel's depth from a smooth surface, see below
  double edge_noise_px = 0.0;     ///< deviation of the outline from a smooth line, see below
  double flying_share = 0.0;      ///< pixels that hang between two surfaces, in parts of those at depth edges
};

/// Measures one hand: `mask` (of the box's size) is 1 where a pixel of `box` is hand.
///
/// Surface noise: for independent normal noise of deviation s, second differences z_(i-1) - 2 z_i + z_(i+1)
/// have deviation s sqrt 6 and mean size s sqrt(12 / pi); taken along rows and columns of the hand where
/// neighbours differ by at most 15 mm. The hand's own curvature adds a little.
///
/// Edge noise: where the outline passes three rows within 3 px of one another, its middle place differs from
/// the mean of the others by noise of deviation s sqrt(3/2). Whole pixels alone give 0.2 to 0.3 px.
///
/// Flying pixels: a depth edge is where two opposite neighbours of a pixel differ by more than 30 mm; the
/// pixel flies if it is more than 10 mm from both.
HandStatistics hand_statistics(const Image<float>& depth_mm, const Box& box, const Image<std::uint8_t>& mask);

/// The mean of each value over the frames in which it could be measured.
HandStatistics mean_of(std::span<const HandStatistics> frames);

}  // namespace knuckle
