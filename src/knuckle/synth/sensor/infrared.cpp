// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/infrared.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "knuckle/core/empty_blocks.h"
#include "knuckle/synth/render/surface_angle.h"
#include "knuckle/synth/sensor/pixel_random.h"

namespace knuckle {
namespace {

constexpr float kMostCounts = 65535.0f;

/// Amplitudes before noise.
Image<float> amplitudes_of(const Image<float>& depth_mm, const Image<float>& cosines, const Camera& camera,
                           double amplitude_at_1_m) {
  constexpr double kSquareMillimetres = 1e6;  ///< in a square metre
  const auto gain = static_cast<float>(amplitude_at_1_m * kSquareMillimetres);
  const Image<float> squares = squared_ray_lengths(camera);
  Image<float> amplitudes(depth_mm.width(), depth_mm.height());
  for_each_seen_block(depth_mm.data(), depth_mm.size(), [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      const float depth = depth_mm.data()[i];
      const float squared_distance = depth * depth * squares.data()[i];
      amplitudes.data()[i] = depth == 0.0f ? 0.0f : gain / squared_distance;
    }
    if (cosines.empty()) return;
    for (std::size_t i = first; i < end; ++i) amplitudes.data()[i] *= cosines.data()[i];
  });
  return amplitudes;
}

void add_noise(Image<float>& amplitudes, const Image<float>& depth_mm, float sigma, std::uint64_t seed) {
  for (std::size_t first = 0; first < amplitudes.size(); first += kPixelsPerBlock) {
    const float* depths = depth_mm.data() + first;
    const std::size_t count = std::min(kPixelsPerBlock, amplitudes.size() - first);
    if (all_zero(depths, count)) continue;
    const auto normals =
        block_normals(seed, PixelUse::infrared, static_cast<std::uint32_t>(first / kPixelsPerBlock));
    for (std::size_t i = 0; i < count; ++i) {
      amplitudes.data()[first + i] += depths[i] == 0.0f ? 0.0f : sigma * normals[i];
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
  for_each_seen_block(depth_mm.data(), counts.size(), [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      const float amplitude = std::min(std::max(amplitudes.data()[i], 0.0f), kMostCounts);
      counts.data()[i] = static_cast<std::uint16_t>(static_cast<std::int32_t>(std::nearbyint(amplitude)));
    }
  });
  return counts;
}

}  // namespace knuckle
