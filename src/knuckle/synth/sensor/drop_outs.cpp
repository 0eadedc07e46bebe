// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/drop_outs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "knuckle/core/empty_blocks.h"
#include "knuckle/core/portable_math.h"
#include "knuckle/synth/sensor/pixel_random.h"

namespace knuckle {
namespace {

void drop_grazing(Image<float>& depth_mm, const Image<float>& cosines, double grazing_deg) {
  const auto least = static_cast<float>(portable_cos(grazing_deg * std::numbers::pi / 180.0));
  for (std::size_t i = 0; i < depth_mm.size(); ++i) {
    float& depth = depth_mm.data()[i];
    depth = cosines.data()[i] < least ? 0.0f : depth;
  }
}

void drop_holes(Image<float>& depth_mm, double share, std::uint64_t seed) {
  const auto below = static_cast<std::uint32_t>(std::nearbyint(share * 65536.0));
  for (std::size_t first = 0; first < depth_mm.size(); first += kPixelsPerBlock) {
    float* depths = depth_mm.data() + first;
    const std::size_t count = std::min(kPixelsPerBlock, depth_mm.size() - first);
    if (all_zero(depths, count)) continue;
    const auto bits = block_bits(seed, PixelUse::hole, static_cast<std::uint32_t>(first / kPixelsPerBlock));
    for (std::size_t i = 0; i < count; ++i) depths[i] = bits[i] < below ? 0.0f : depths[i];
  }
}

}  // namespace

void DropOutOptions::visit(OptionVisitor& visitor) {
  visitor.real("grazing_deg", grazing_deg, closed(0, 90));
  visitor.real("near_mm", near_mm, closed(0, 10000));
  visitor.real("range_mm", range_mm, closed(0, 10000));
  visitor.real("hole_share", hole_share, closed(0, 1));
}

Image<float> with_drop_outs(Image<float> depth_mm, const Image<float>& cosines, const DropOutOptions& options,
                            std::uint64_t seed) {
  const auto nearest = static_cast<float>(options.near_mm);
  const float farthest =
      options.range_mm > 0.0 ? static_cast<float>(options.range_mm) : std::numeric_limits<float>::infinity();
  for (float& depth : depth_mm.pixels()) {
    depth = depth > 0.0f && depth >= nearest && depth <= farthest ? depth : 0.0f;
  }
  if (options.grazing_deg < 90.0 && !cosines.empty()) drop_grazing(depth_mm, cosines, options.grazing_deg);
  if (options.hole_share > 0.0) drop_holes(depth_mm, options.hole_share, seed);
  return depth_mm;
}

}  // namespace knuckle
