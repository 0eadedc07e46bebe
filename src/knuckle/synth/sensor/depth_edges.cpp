// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/depth_edges.h"

#include <cmath>
#include <cstring>

namespace knuckle {
namespace {

/// Eight flags are looked at together: most pixels are inside a surface or see nothing.
constexpr int kFlagsPerWord = 8;

bool any_of_eight(const std::uint8_t* flags) {
  std::uint64_t word = 0;
  std::memcpy(&word, flags, sizeof(word));
  return word != 0;
}

void add_jumps_along(const float* depths, int width, float jump_mm, std::uint8_t* flags) {
  for (int i = 0; i + 1 < width; ++i) {
    flags[i] |= static_cast<std::uint8_t>(std::abs(depths[i] - depths[i + 1]) > jump_mm);
  }
  for (int i = 1; i < width; ++i) {
    flags[i] |= static_cast<std::uint8_t>(std::abs(depths[i] - depths[i - 1]) > jump_mm);
  }
}

void add_jumps_between(const float* depths, const float* others, int width, float jump_mm,
                       std::uint8_t* flags) {
  for (int i = 0; i < width; ++i) {
    flags[i] |= static_cast<std::uint8_t>(std::abs(depths[i] - others[i]) > jump_mm);
  }
}

}  // namespace

std::vector<std::int32_t> edge_pixels(const Image<float>& depth_mm, double jump_mm) {
  const int width = depth_mm.width();
  const int height = depth_mm.height();
  const auto jump = static_cast<float>(jump_mm);
  std::vector<std::uint8_t> flags(width + kFlagsPerWord);  // the last word reads over the row's end
  std::vector<std::int32_t> pixels;
  for (int row = 0; row < height; ++row) {
    const float* depths = depth_mm.row(row).data();
    std::fill(flags.begin(), flags.end(), std::uint8_t{0});
    add_jumps_along(depths, width, jump, flags.data());
    if (row > 0) add_jumps_between(depths, depth_mm.row(row - 1).data(), width, jump, flags.data());
    if (row + 1 < height) add_jumps_between(depths, depth_mm.row(row + 1).data(), width, jump, flags.data());
    for (int first = 0; first < width; first += kFlagsPerWord) {
      if (!any_of_eight(flags.data() + first)) continue;
      for (int i = first; i < first + kFlagsPerWord; ++i) {
        if (flags[i] != 0) pixels.push_back(row * width + i);
      }
    }
  }
  return pixels;
}

}  // namespace knuckle
