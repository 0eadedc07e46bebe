// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/depth_image.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "knuckle/core/empty_blocks.h"

namespace knuckle {
namespace {

constexpr double kMostCounts = std::numeric_limits<std::uint16_t>::max();

bool is_kept(float depth_mm, double unit_mm) {
  const double count = std::floor(depth_mm / unit_mm + 0.5);
  return count <= kMostCounts && static_cast<float>(count * unit_mm) == depth_mm;
}

}  // namespace

Image<float> depth_from_counts(const Image<std::uint16_t>& counts, double unit_mm) {
  Image<float> depth_mm(counts.width(), counts.height());
  std::ranges::transform(counts.pixels(), depth_mm.pixels().begin(),
                         [unit_mm](std::uint16_t count) { return static_cast<float>(count * unit_mm); });
  return depth_mm;
}

Image<std::uint16_t> counts_from_depth(const Image<float>& depth_mm, double unit_mm, std::string_view where) {
  constexpr double kHighest = std::numeric_limits<std::uint16_t>::max();
  Image<std::uint16_t> counts(depth_mm.width(), depth_mm.height());
  const float* from = depth_mm.data();
  std::uint16_t* to = counts.data();
  for_each_seen_block(from, counts.size(), [&](std::size_t first, std::size_t end) {
    float deepest = 0.0f;
    for (std::size_t i = first; i < end; ++i) deepest = from[i] > deepest ? from[i] : deepest;
    if (!(deepest / unit_mm + 0.5 < kHighest + 1)) {
      fail("{}: a depth of {} mm exceeds the {} mm that 16 bits hold in units of {} mm", where, deepest,
           kHighest * unit_mm, unit_mm);
    }
    // No way out of the loop, and no call in it: the compiler takes many pixels at once.
    for (std::size_t i = first; i < end; ++i) {
      const double depth = from[i] > 0.0f ? from[i] : 0.0f;
      const double half_above = depth / unit_mm + 0.5;  // is cut off to the nearest count
      to[i] = static_cast<std::uint16_t>(static_cast<std::int32_t>(half_above));
    }
  });
  return counts;
}

bool is_exact_in(const Image<float>& depth_mm, double unit_mm) {
  return std::ranges::all_of(depth_mm.pixels(),
                             [unit_mm](float depth) { return !(depth > 0.0f) || is_kept(depth, unit_mm); });
}

std::optional<double> exact_depth_unit_mm(const Image<float>& depth_mm) {
  const auto* const unit =
      std::ranges::find_if(kDepthUnitsMm, [&](double unit_mm) { return is_exact_in(depth_mm, unit_mm); });
  return unit == kDepthUnitsMm.end() ? std::nullopt : std::optional(*unit);
}

double suitable_depth_unit_mm(const Image<float>& depth_mm) {
  if (const auto exact = exact_depth_unit_mm(depth_mm)) return *exact;
  return reaches_all(depth_mm, kDepthUnitsMm.back()) ? kDepthUnitsMm.back() : kDepthUnitsMm.front();
}

bool reaches_all(const Image<float>& depth_mm, double unit_mm) {
  float deepest = 0.0f;
  for (const float depth : depth_mm.pixels()) deepest = depth > deepest ? depth : deepest;
  return deepest <= unit_mm * kMostCounts;
}

Image<std::uint16_t> near_counts_from_depth(const Image<float>& depth_mm, double unit_mm) {
  Image<std::uint16_t> counts(depth_mm.width(), depth_mm.height());
  std::ranges::transform(depth_mm.pixels(), counts.pixels().begin(), [unit_mm](float depth) {
    const double half_above = (depth > 0.0f ? depth : 0.0f) / unit_mm + 0.5;  // is cut off to the count
    return half_above < kMostCounts + 1 ? static_cast<std::uint16_t>(half_above) : std::uint16_t{0};
  });
  return counts;
}

Image<std::uint8_t> mask_from_pixels(Image<std::uint8_t> pixels) {
  for (std::uint8_t& pixel : pixels.pixels()) pixel = pixel != 0 ? 1 : 0;
  return pixels;
}

}  // namespace knuckle
