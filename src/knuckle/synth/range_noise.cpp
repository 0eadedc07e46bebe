// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/range_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "knuckle/synth/pixel_random.h"

namespace knuckle {
namespace {

constexpr double kSteepest = 85.0 * std::numbers::pi / 180.0;
constexpr double kPerSquareMetre = 1e-6;  ///< [1 / mm^2]

/// theta^2 / (pi / 2 - theta)^2.
double growth_with_angle(double cosine) {
  const double theta = std::min(std::acos(std::clamp(cosine, 0.0, 1.0)), kSteepest);
  const double ratio = theta / (std::numbers::pi / 2.0 - theta);
  return ratio * ratio;
}

/// The same from a table over the cosine: an arc cosine a pixel would cost more than all the rest.
float tabled_growth_with_angle(float cosine) {
  constexpr int kSteps = 1024;
  static const std::vector<float> table = [] {
    std::vector<float> values(kSteps + 1);
    for (int i = 0; i <= kSteps; ++i) {
      values[i] = static_cast<float>(growth_with_angle(static_cast<double>(i) / kSteps));
    }
    return values;
  }();
  return table[static_cast<int>(cosine * kSteps + 0.5f)];
}

/// Adds noise to the pixels of one block. `sigma_of(i)` is the deviation at its pixel number i.
template <class Sigma>
void add_noise(float* depths, std::size_t count, std::uint64_t seed, std::uint32_t block,
               const Sigma& sigma_of) {
  const auto bits = block_bits(seed, PixelUse::range_noise, block);
  for (std::size_t i = 0; i < count; ++i) {
    if (depths[i] != 0.0f) depths[i] += sigma_of(i) * normal_from_bits(bits[i]);
  }
}

}  // namespace

void RangeNoiseOptions::visit(OptionVisitor& visitor) {
  visitor.real("sigma_mm", sigma_mm, closed(0, 100));
  visitor.real("growth_mm", growth_mm, closed(0, 1000));
  visitor.real("slant_mm", slant_mm, closed(0, 100));
}

double range_sigma_mm(const RangeNoiseOptions& options, double depth_mm, double cosine) {
  return options.sigma_mm + options.growth_mm * depth_mm * depth_mm * kPerSquareMetre +
         options.slant_mm * growth_with_angle(cosine);
}

Image<float> with_range_noise(Image<float> depth_mm, const Image<float>& cosines,
                              const RangeNoiseOptions& options, std::uint64_t seed) {
  const auto sigma = static_cast<float>(options.sigma_mm);
  const auto growth = static_cast<float>(options.growth_mm * kPerSquareMetre);
  const auto slant = cosines.empty() ? 0.0f : static_cast<float>(options.slant_mm);
  if (sigma == 0.0f && growth == 0.0f && slant == 0.0f) return depth_mm;
  for (std::size_t first = 0; first < depth_mm.size(); first += kPixelsABlock) {
    float* depths = depth_mm.data() + first;
    const std::size_t count = std::min(kPixelsABlock, depth_mm.size() - first);
    if (std::all_of(depths, depths + count, [](float depth) { return depth == 0.0f; })) continue;
    const auto block = static_cast<std::uint32_t>(first / kPixelsABlock);
    const auto facing_sigma = [&](std::size_t i) { return sigma + growth * depths[i] * depths[i]; };
    if (slant == 0.0f) {
      add_noise(depths, count, seed, block, facing_sigma);
    } else {
      const float* slants = cosines.data() + first;
      add_noise(depths, count, seed, block,
                [&](std::size_t i) { return facing_sigma(i) + slant * tabled_growth_with_angle(slants[i]); });
    }
  }
  return depth_mm;
}

}  // namespace knuckle
