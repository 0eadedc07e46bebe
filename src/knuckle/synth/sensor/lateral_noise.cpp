// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/lateral_noise.h"

#include <algorithm>
#include <cmath>

#include "knuckle/synth/sensor/pixel_random.h"

namespace knuckle {

void LateralNoiseOptions::visit(OptionVisitor& visitor) {
  visitor.real("lateral_px", lateral_px, closed(0, 2));
}

std::vector<DisplacedPixel> displaced_pixels(std::span<const std::int32_t> edges, int width, int height,
                                             const LateralNoiseOptions& options, std::uint64_t seed) {
  std::vector<DisplacedPixel> result;
  if (options.lateral_px == 0.0) return result;
  const auto sigma = static_cast<float>(options.lateral_px);
  const auto displacement = [&](std::uint32_t word) {
    return static_cast<int>(std::nearbyint(sigma * normal_from_bits(static_cast<std::uint16_t>(word))));
  };
  for (const std::int32_t pixel : edges) {
    const auto words = pixel_words(seed, PixelUse::lateral, static_cast<std::uint32_t>(pixel));
    const int column = std::clamp(pixel % width + displacement(words[0]), 0, width - 1);
    const int row = std::clamp(pixel / width + displacement(words[1]), 0, height - 1);
    const std::int32_t source = row * width + column;
    if (source != pixel) result.push_back({pixel, source});
  }
  return result;
}

Image<float> displaced(const Image<float>& image, std::span<const DisplacedPixel> pixels) {
  Image<float> result = image;
  for (const DisplacedPixel& moved : pixels) result.data()[moved.pixel] = image.data()[moved.source];
  return result;
}

}  // namespace knuckle
