// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "knuckle/core/box.h"
#include "knuckle/core/image.h"

namespace knuckle {

/// The pixels of one hand in one image, as lengths of runs, row by row: first of pixels that are not hand
/// (maybe 0 of them), then of those that are, and so on in turn.
struct LabelMask {
  int width = 0;   ///< of the image [px]
  int height = 0;  ///< of the image [px]
  std::vector<std::int64_t> runs;

  bool operator==(const LabelMask&) const = default;
};

/// The most runs that a mask may have, so that its line in the file stays readable.
inline constexpr std::size_t kMostMaskRuns = 100'000;

/// `pixels`: 0 where a pixel is not hand.
LabelMask mask_from_pixels_of_hand(const Image<std::uint8_t>& pixels);
/// 1 where a pixel is hand, else 0. Throws an Error where the runs do not fill the image exactly, one is
/// below 0, or there are more than kMostMaskRuns.
Image<std::uint8_t> pixels_of(const LabelMask& mask);

/// The smallest box that holds all pixels of the hand; an empty one where there are none.
Box box_of(const Image<std::uint8_t>& pixels);

}  // namespace knuckle
