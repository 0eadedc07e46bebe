// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/range_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "knuckle/core/empty_blocks.h"
#include "knuckle/core/portable_math.h"
#include "knuckle/synth/sensor/pixel_random.h"

namespace knuckle {
namespace {

constexpr double kSteepest = 85.0 * std::numbers::pi / 180.0;
constexpr double kPerSquareMetre = 1e-6;  ///< [1 / mm^2]

/// theta^2 / (pi / 2 - theta)^2.
double growth_with_angle(double cosine) {
  const double theta = std::min(portable_acos(std::clamp(cosine, 0.0, 1.0)), kSteepest);
  const double ratio = theta / (std::numbers::pi / 2.0 - theta);
  return ratio * ratio;
}

/// The same from a table over the cosine: an arc cosine per pixel would cost more than all the rest.
class AngleTable {
 public:
  AngleTable() {
    for (int i = 0; i <= kSteps; ++i) {
      values_[i] = static_cast<float>(growth_with_angle(static_cast<double>(i) / kSteps));
    }
  }
  float operator()(float cosine) const { return values_[static_cast<int>(std::nearbyint(cosine * kSteps))]; }

 private:
  static constexpr int kSteps = 1024;
  std::array<float, kSteps + 1> values_;
};

const AngleTable& angle_table() {
  static const AngleTable table;
  return table;
}

/// The deviation at a pixel.
class SigmaOf {
 public:
  SigmaOf(const RangeNoiseOptions& options, const Image<float>& cosines)
      : sigma_(static_cast<float>(options.sigma_mm)),
        growth_(static_cast<float>(options.growth_mm * kPerSquareMetre)),
        slant_(cosines.empty() ? 0.0f : static_cast<float>(options.slant_mm)),
        cosines_(cosines.data()),
        angle_growth_(angle_table()) {}

  bool is_silent() const { return sigma_ == 0.0f && growth_ == 0.0f && slant_ == 0.0f; }

  float operator()(std::size_t pixel, float depth_mm) const {
    const float facing = sigma_ + growth_ * depth_mm * depth_mm;
    return slant_ == 0.0f ? facing : facing + slant_ * angle_growth_(cosines_[pixel]);
  }

 private:
  float sigma_;
  float growth_;
  float slant_;
  const float* cosines_;
  const AngleTable& angle_growth_;
};

void add_noise_of_pixels(Image<float>& depth_mm, const SigmaOf& sigma_of, std::uint64_t seed) {
  for (std::size_t first = 0; first < depth_mm.size(); first += kPixelsPerBlock) {
    float* depths = depth_mm.data() + first;
    const std::size_t count = std::min(kPixelsPerBlock, depth_mm.size() - first);
    if (all_zero(depths, count)) continue;
    const auto block = static_cast<std::uint32_t>(first / kPixelsPerBlock);
    const auto normals = block_normals(seed, PixelUse::range_noise, block);
    for (std::size_t i = 0; i < count; ++i) {
      depths[i] += depths[i] == 0.0f ? 0.0f : sigma_of(first + i, depths[i]) * normals[i];
    }
  }
}

/// Weights of two independent neighbours at a place in [0, 1) between them: linear, with squares that sum
/// to 1.
struct Weights {
  float before;
  float after;

  explicit Weights(float place) {
    const float length = std::sqrt((1.0f - place) * (1.0f - place) + place * place);
    before = (1.0f - place) / length;
    after = place / length;
  }
};

/// Rows of normal numbers that are interpolated on a lattice.
class GrainRows {
 public:
  GrainRows(int width, int grain_px, std::uint64_t seed)
      : grain_px_(grain_px), seed_(seed), blocks_((width / grain_px + 2 + kBlock - 1) / kBlock) {
    for (int i = 0; i < grain_px; ++i) weights_.emplace_back(static_cast<float>(i) / grain_px);
    above_.resize(static_cast<std::size_t>(blocks_) * kBlock);
    below_ = mixed_ = above_;
    normals_.resize((width / grain_px + 1) * grain_px);
  }

  /// Those of a row's pixels, and some more after.
  const float* row(int row) {
    set_lattice_row(row / grain_px_);
    const Weights across = weights_[row % grain_px_];
    for (std::size_t i = 0; i < mixed_.size(); ++i) {
      mixed_[i] = across.before * above_[i] + across.after * below_[i];
    }
    float* normal = normals_.data();
    for (std::size_t node = 0; node < normals_.size() / grain_px_; ++node) {
      for (const Weights& along : weights_) {
        *normal++ = along.before * mixed_[node] + along.after * mixed_[node + 1];
      }
    }
    return normals_.data();
  }

 private:
  static constexpr int kBlock = static_cast<int>(kPixelsPerBlock);

  void set_lattice_row(int row) {
    if (row == lattice_row_) return;
    lattice_row_ = row;
    fill(above_, row);
    fill(below_, row + 1);
  }

  void fill(std::vector<float>& nodes, int lattice_row) const {
    for (int block = 0; block < blocks_; ++block) {
      const auto number = static_cast<std::uint32_t>(lattice_row * blocks_ + block);
      std::ranges::copy(block_normals(seed_, PixelUse::grain, number), nodes.begin() + block * kBlock);
    }
  }

  int grain_px_;
  std::uint64_t seed_;
  int blocks_;  ///< blocks of nodes in a row of the lattice
  int lattice_row_ = -1;
  std::vector<Weights> weights_;  ///< of the pixels between two nodes
  std::vector<float> above_;
  std::vector<float> below_;
  std::vector<float> mixed_;
  std::vector<float> normals_;
};

void add_noise_of_grains(Image<float>& depth_mm, const SigmaOf& sigma_of, int grain_px, std::uint64_t seed) {
  GrainRows grains(depth_mm.width(), grain_px, seed);
  for (int row = 0; row < depth_mm.height(); ++row) {
    float* depths = depth_mm.row(row).data();
    if (all_zero(depths, static_cast<std::size_t>(depth_mm.width()))) continue;
    const float* normals = grains.row(row);
    const std::size_t first = static_cast<std::size_t>(row) * depth_mm.width();
    for (int i = 0; i < depth_mm.width(); ++i) {
      depths[i] += depths[i] == 0.0f ? 0.0f : sigma_of(first + i, depths[i]) * normals[i];
    }
  }
}

}  // namespace

void RangeNoiseOptions::visit(OptionVisitor& visitor) {
  visitor.real("sigma_mm", sigma_mm, closed(0, 100));
  visitor.real("growth_mm", growth_mm, closed(0, 1000));
  visitor.real("slant_mm", slant_mm, closed(0, 100));
  visitor.integer("grain_px", grain_px, closed(1, 64));
}

double range_sigma_mm(const RangeNoiseOptions& options, double depth_mm, double cosine) {
  return options.sigma_mm + options.growth_mm * depth_mm * depth_mm * kPerSquareMetre +
         options.slant_mm * growth_with_angle(cosine);
}

Image<float> with_range_noise(Image<float> depth_mm, const Image<float>& cosines,
                              const RangeNoiseOptions& options, std::uint64_t seed) {
  const SigmaOf sigma_of(options, cosines);
  if (sigma_of.is_silent()) return depth_mm;
  if (options.grain_px == 1) {
    add_noise_of_pixels(depth_mm, sigma_of, seed);
  } else {
    add_noise_of_grains(depth_mm, sigma_of, options.grain_px, seed);
  }
  return depth_mm;
}

}  // namespace knuckle
