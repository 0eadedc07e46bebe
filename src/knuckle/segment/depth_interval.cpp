// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/depth_interval.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace knuckle {

std::vector<std::int32_t> pixels_between(const Image<float>& depth_mm, double near_mm, double far_mm) {
  const auto low = std::max(static_cast<float>(near_mm), std::numeric_limits<float>::min());
  const auto high = std::min(static_cast<float>(far_mm), std::numeric_limits<float>::max());
  // Most pixels are out of the interval, in long runs: eight flags at once say whether there is one to look
  // at.
  const std::size_t size = depth_mm.size();
  std::vector<std::uint8_t> flags((size + 7) / 8 * 8);
  const float* const depth = depth_mm.data();
  int count = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const int is_between = static_cast<int>(depth[i] >= low) & static_cast<int>(depth[i] <= high);
    flags[i] = static_cast<std::uint8_t>(is_between);
    count += is_between;
  }
  std::vector<std::int32_t> pixels(static_cast<std::size_t>(count) + 1);  // one more is written and dropped
  std::int32_t* next = pixels.data();
  for (std::size_t i = 0; i < flags.size(); i += 8) {
    std::uint64_t eight_flags = 0;
    std::memcpy(&eight_flags, &flags[i], sizeof(eight_flags));
    if (eight_flags == 0) continue;
    for (std::size_t k = i; k < i + 8; ++k) {
      *next = static_cast<std::int32_t>(k);
      next += flags[k];
    }
  }
  pixels.pop_back();
  return pixels;
}

}  // namespace knuckle
