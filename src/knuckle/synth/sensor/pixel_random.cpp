// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/pixel_random.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "knuckle/core/portable_math.h"
#include "knuckle/core/random.h"

namespace knuckle {
namespace {

constexpr int kQuantiles = 1 << 16;
/// Second counter word of blocks and of single pixels: they never share a counter.
constexpr std::uint32_t kBlocks = 0;
constexpr std::uint32_t kPixels = 1;

/// x with P(X < x) = probability for a standard normal X, by Newton's method from the centre outwards.
double normal_quantile(double probability, double start) {
  double x = start;
  for (int iteration = 0; iteration < 50; ++iteration) {
    const double cumulative = 0.5 * std::erfc(-x / std::numbers::sqrt2);
    const double density = portable_exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
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

std::array<std::uint32_t, 2> key_of(std::uint64_t seed) {
  return {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)};
}

}  // namespace

std::array<std::uint16_t, kPixelsPerBlock> block_bits(std::uint64_t seed, PixelUse use, std::uint32_t block) {
  const auto words = philox({block, kBlocks, static_cast<std::uint32_t>(use), 0}, key_of(seed));
  std::array<std::uint16_t, kPixelsPerBlock> bits;
  for (std::size_t i = 0; i < words.size(); ++i) {
    bits[2 * i] = static_cast<std::uint16_t>(words[i]);
    bits[2 * i + 1] = static_cast<std::uint16_t>(words[i] >> 16);
  }
  return bits;
}

std::array<float, kPixelsPerBlock> block_normals(std::uint64_t seed, PixelUse use, std::uint32_t block) {
  const std::vector<float>& table = normal_table();
  const auto bits = block_bits(seed, use, block);
  std::array<float, kPixelsPerBlock> normals;
  for (std::size_t i = 0; i < normals.size(); ++i) normals[i] = table[bits[i]];
  return normals;
}

std::array<std::uint32_t, 4> pixel_words(std::uint64_t seed, PixelUse use, std::uint32_t pixel) {
  return philox({pixel, kPixels, static_cast<std::uint32_t>(use), 0}, key_of(seed));
}

float normal_from_bits(std::uint16_t bits) {
  return normal_table()[bits];
}

}  // namespace knuckle
