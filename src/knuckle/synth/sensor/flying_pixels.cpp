// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/flying_pixels.h"

#include <array>
#include <cmath>

#include "knuckle/synth/sensor/pixel_random.h"

namespace knuckle {
namespace {

/// The depth of that one of four neighbours which differs most, of those that see something; the pixel's own
/// where there is none.
float most_different_neighbour(const Image<float>& depth_mm, std::int32_t pixel) {
  const int column = pixel % depth_mm.width();
  const int row = pixel / depth_mm.width();
  const float own = depth_mm(column, row);
  float most = own;
  const auto look_at = [&](int x, int y) {
    if (!depth_mm.contains(x, y) || depth_mm(x, y) == 0.0f) return;
    if (std::abs(depth_mm(x, y) - own) > std::abs(most - own)) most = depth_mm(x, y);
  };
  look_at(column - 1, row);
  look_at(column + 1, row);
  look_at(column, row - 1);
  look_at(column, row + 1);
  return most;
}

float mixed_depth(float own, float other, float share_of_other) {
  const float own_light = (1.0f - share_of_other) / (own * own);
  const float other_light = share_of_other / (other * other);
  return (own * own_light + other * other_light) / (own_light + other_light);
}

}  // namespace

void FlyingPixelOptions::visit(OptionVisitor& visitor) {
  visitor.real("flying_px", flying_px, closed(0, 2));
}

Image<float> with_flying_pixels(const Image<float>& depth_mm, std::span<const std::int32_t> edges,
                                const FlyingPixelOptions& options, std::uint64_t seed) {
  Image<float> result = depth_mm;
  if (options.flying_px == 0.0) return result;
  const auto seen_px = static_cast<float>(options.flying_px);
  for (const std::int32_t pixel : edges) {
    const float own = depth_mm.data()[pixel];
    if (own == 0.0f) continue;
    const auto words = pixel_words(seed, PixelUse::flying, static_cast<std::uint32_t>(pixel));
    const float share = 0.5f - uniform_from_bits(words[0]) / seen_px;
    const float other = most_different_neighbour(depth_mm, pixel);
    if (share > 0.0f && other != own) result.data()[pixel] = mixed_depth(own, other, share);
  }
  return result;
}

}  // namespace knuckle
