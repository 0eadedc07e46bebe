// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_mask.h"

#include <algorithm>

#include "knuckle/core/error.h"

namespace knuckle {

LabelMask mask_from_pixels_of_hand(const Image<std::uint8_t>& pixels) {
  LabelMask mask{.width = pixels.width(), .height = pixels.height(), .runs = {}};
  bool is_hand = false;
  std::int64_t run = 0;
  for (const std::uint8_t pixel : pixels.pixels()) {
    if ((pixel != 0) != is_hand) {
      mask.runs.push_back(run);
      is_hand = !is_hand;
      run = 0;
    }
    ++run;
  }
  mask.runs.push_back(run);
  return mask;
}

Image<std::uint8_t> pixels_of(const LabelMask& mask) {
  if (mask.runs.size() > kMostMaskRuns)
    fail("a mask of {} runs, expected {} at most", mask.runs.size(), kMostMaskRuns);
  Image<std::uint8_t> pixels(mask.width, mask.height);
  const std::int64_t size = std::int64_t{mask.width} * mask.height;
  std::int64_t end = 0;
  bool is_hand = false;
  for (const std::int64_t run : mask.runs) {
    if (run < 0 || run > size - end)
      fail("a mask's run of {} pixels, expected 0 to {}: that many are left of the image", run, size - end);
    std::fill_n(pixels.data() + end, run, static_cast<std::uint8_t>(is_hand ? 1 : 0));
    end += run;
    is_hand = !is_hand;
  }
  if (end != size)
    fail("a mask's runs have {} pixels, expected {} ({}x{})", end, size, mask.width, mask.height);
  return pixels;
}

Box box_of(const Image<std::uint8_t>& pixels) {
  int left = pixels.width();
  int top = pixels.height();
  int right = -1;
  int bottom = -1;
  for (int row = 0; row < pixels.height(); ++row) {
    for (int column = 0; column < pixels.width(); ++column) {
      if (pixels(column, row) == 0) continue;
      left = std::min(left, column);
      right = std::max(right, column);
      top = std::min(top, row);
      bottom = row;
    }
  }
  return right < 0 ? Box{} : Box{left, top, right - left + 1, bottom - top + 1};
}

}  // namespace knuckle
