// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/range_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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
class AngleTable {
 public:
  AngleTable() {
    for (int i = 0; i <= kSteps; ++i) {
      values_[i] = static_cast<float>(growth_with_angle(static_cast<double>(i) / kSteps));
    }
  }
  float operator()(float cosine) const { return values_[static_cast<int>(cosine * kSteps + 0.5f)]; }

 private:
  static constexpr int kSteps = 1024;
  std::array<float, kSteps + 1> values_;
};

const AngleTable& angle_table() {
  static const AngleTable table;
  return table;
}

/// Adds noise to the pixels of one block. `sigma_of(i)` is the deviation at its pixel number i.
template <class Sigma>
void add_noise(float* depths, std::size_t count, std::uint64_t seed, std::uint32_t block,
               const Sigma& sigma_of) {
  const auto normals = block_normals(seed, PixelUse::range_noise, block);
  for (std::size_t i = 0; i < count; ++i) {
    depths[i] += depths[i] == 0.0f ? 0.0f : sigma_of(i) * normals[i];
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
  const AngleTable& angle_growth = angle_table();
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
                [&](std::size_t i) { return facing_sigma(i) + slant * angle_growth(slants[i]); });
    }
  }
  return depth_mm;
}

}  // namespace knuckle
