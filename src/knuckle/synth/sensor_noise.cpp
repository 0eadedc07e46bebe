// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

/// Normal numbers come from a table of equally likely values, picked by 16 random bits: eight from one Philox
/// block, without a logarithm. It ends at 4.3 deviations.
constexpr int kQuantiles = 1 << 16;
constexpr std::size_t kNormalsABlock = 8;

/// x with P(X < x) = probability for a standard normal X, by Newton's method from the centre outwards.
double normal_quantile(double probability, double start) {
  double x = start;
  for (int iteration = 0; iteration < 50; ++iteration) {
    const double cumulative = 0.5 * std::erfc(-x / std::numbers::sqrt2);
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
    const double step = (probability - cumulative) / density;
    x += step;
    if (std::abs(step) < 1e-10) break;
  }
  return x;
}

std::vector<float> normal_quantiles() {
  std::vector<float> table(kQuantiles);
  double x = 0.0;
  for (int i = kQuantiles / 2; i < kQuantiles; ++i) {
    x = normal_quantile((i + 0.5) / kQuantiles, x);
    table[i] = static_cast<float>(x);
    table[kQuantiles - 1 - i] = static_cast<float>(-x);
  }
  return table;
}

const std::vector<float>& normal_table() {
  static const std::vector<float> quantiles = normal_quantiles();
  return quantiles;
}

std::array<float, kNormalsABlock> normals(std::uint64_t seed, std::uint32_t block) {
  const std::array<std::uint32_t, 2> key = {static_cast<std::uint32_t>(seed),
                                            static_cast<std::uint32_t>(seed >> 32)};
  const std::array<std::uint32_t, 4> words = philox({block, 0, 0, 0}, key);
  const std::vector<float>& table = normal_table();
  std::array<float, kNormalsABlock> result;
  for (std::size_t i = 0; i < words.size(); ++i) {
    result[2 * i] = table[words[i] & 0xffffu];
    result[2 * i + 1] = table[words[i] >> 16];
  }
  return result;
}

void add_noise(Image<float>& depth_mm, float sigma_mm, std::uint64_t seed) {
  float* depths = depth_mm.data();
  for (std::size_t first = 0; first < depth_mm.size(); first += kNormalsABlock) {
    const std::size_t count = std::min(kNormalsABlock, depth_mm.size() - first);
    if (std::all_of(depths + first, depths + first + count, [](float depth) { return depth == 0.0f; }))
      continue;
    const auto noise = normals(seed, static_cast<std::uint32_t>(first / kNormalsABlock));
    for (std::size_t i = 0; i < count; ++i) {
      if (depths[first + i] != 0.0f) depths[first + i] += sigma_mm * noise[i];
    }
  }
}

}  // namespace

void SensorOptions::visit(OptionVisitor& visitor) {
  visitor.real("sigma_mm", sigma_mm, closed(0, 100));
  visitor.real("quantisation_mm", quantisation_mm, closed(0, 100));
  visitor.real("background_mm", background_mm, closed(0, 10000));
  visitor.real("range_mm", range_mm, closed(0, 10000));
}

Image<float> measured(const Image<float>& depth_mm, const SensorOptions& options, std::uint64_t seed) {
  check_options(options, "sensor");
  Image<float> result = depth_mm;
  const auto wall = static_cast<float>(options.background_mm);
  if (wall > 0.0f) {
    for (float& depth : result.pixels()) depth = depth == 0.0f ? wall : std::min(depth, wall);
  }
  if (options.sigma_mm > 0.0) add_noise(result, static_cast<float>(options.sigma_mm), seed);
  const auto step = static_cast<float>(options.quantisation_mm);
  if (step > 0.0f) {
    for (float& depth : result.pixels()) depth = std::nearbyint(depth / step) * step;
  }
  const float farthest =
      options.range_mm > 0.0 ? static_cast<float>(options.range_mm) : std::numeric_limits<float>::infinity();
  for (float& depth : result.pixels()) depth = depth > 0.0f && depth <= farthest ? depth : 0.0f;
  return result;
}

}  // namespace knuckle
