// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/infrared.h"

#include <algorithm>
#include <vector>

#include "knuckle/synth/pixel_random.h"
#include "knuckle/synth/surface_angle.h"

namespace knuckle {
namespace {

/// Amplitudes before noise.
Image<float> amplitudes_of(const Image<float>& depth_mm, const Image<float>& cosines, const Camera& camera,
                           double amplitude_at_1_m) {
  constexpr double kSquareMillimetres = 1e6;  ///< in a square metre
  const auto gain = static_cast<float>(amplitude_at_1_m * kSquareMillimetres);
  const RayLengths ray_length(camera);
  Image<float> amplitudes(depth_mm.width(), depth_mm.height());
  for (int row = 0; row < depth_mm.height(); ++row) {
    const float* depths = depth_mm.row(row).data();
    const float* facing = cosines.empty() ? nullptr : cosines.row(row).data();
    float* result = amplitudes.row(row).data();
    for (int column = 0; column < depth_mm.width(); ++column) {
      if (depths[column] == 0.0f) continue;
      const float distance = depths[column] * ray_length(column, row);
      result[column] = gain * (facing == nullptr ? 1.0f : facing[column]) / (distance * distance);
    }
  }
  return amplitudes;
}

void add_noise(Image<float>& amplitudes, const Image<float>& depth_mm, float sigma, std::uint64_t seed) {
  for (std::size_t first = 0; first < amplitudes.size(); first += kPixelsABlock) {
    const float* depths = depth_mm.data() + first;
    const std::size_t count = std::min(kPixelsABlock, amplitudes.size() - first);
    if (std::all_of(depths, depths + count, [](float depth) { return depth == 0.0f; })) continue;
    const auto bits = block_bits(seed, PixelUse::infrared, static_cast<std::uint32_t>(first / kPixelsABlock));
    for (std::size_t i = 0; i < count; ++i) {
      if (depths[i] != 0.0f) amplitudes.data()[first + i] += sigma * normal_from_bits(bits[i]);
    }
  }
}

}  // namespace

void InfraredOptions::visit(OptionVisitor& visitor) {
  visitor.real("infrared", infrared, closed(0, 100000));
  visitor.real("infrared_sigma", infrared_sigma, closed(0, 10000));
}

Image<std::uint16_t> infrared_image(const Image<float>& depth_mm, const Image<float>& cosines,
                                    const Camera& camera, const InfraredOptions& options,
                                    std::uint64_t seed) {
  Image<float> amplitudes = amplitudes_of(depth_mm, cosines, camera, options.infrared);
  if (options.infrared_sigma > 0.0) {
    add_noise(amplitudes, depth_mm, static_cast<float>(options.infrared_sigma), seed);
  }
  Image<std::uint16_t> counts(depth_mm.width(), depth_mm.height());
  std::ranges::transform(amplitudes.pixels(), counts.pixels().begin(), [](float amplitude) {
    return static_cast<std::uint16_t>(std::clamp(amplitude, 0.0f, 65535.0f) + 0.5f);
  });
  return counts;
}

}  // namespace knuckle
