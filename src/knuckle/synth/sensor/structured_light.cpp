// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/structured_light.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace knuckle {
namespace {

/// Points of one surface that fall into the same column differ by less than this in disparity [px].
constexpr float kSameSurface = 2.0f;

/// What the projector sees of a row: the largest disparity (the nearest point) in each of its columns.
class ProjectorRow {
 public:
  /// Depth z is seen from the projector's side displaced by `focal_baseline` / z columns to the left.
  ProjectorRow(float focal_baseline, float jump_mm) : focal_baseline_(focal_baseline), jump_mm_(jump_mm) {}

  /// Sees another row; memory is that of the row before.
  void see(std::span<const float> depths) {
    depths_ = depths;
    disparities_.resize(depths.size());
    columns_.resize(depths.size());
    float largest = 0.0f;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      disparities_[i] = depths[i] == 0.0f ? 0.0f : std::abs(focal_baseline_) / depths[i];
      largest = std::max(largest, disparities_[i]);
    }
    nearest_.assign(depths.size() + static_cast<std::size_t>(std::ceil(largest)) + 2, 0.0f);
    const float origin = focal_baseline_ > 0.0f ? std::ceil(largest) : 0.0f;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      const float displacement = focal_baseline_ > 0.0f ? -disparities_[i] : disparities_[i];
      columns_[i] = static_cast<std::int32_t>(std::nearbyint(static_cast<float>(i) + displacement + origin));
    }
    for (std::size_t i = 0; i < depths.size(); ++i) {
      if (depths[i] != 0.0f) draw(i);
    }
  }

  bool is_shadowed(std::size_t i) const { return nearest_at(columns_[i]) > disparities_[i] + kSameSurface; }

 private:
  float& nearest_at(std::int32_t column) { return nearest_[static_cast<std::size_t>(column)]; }
  float nearest_at(std::int32_t column) const { return nearest_[static_cast<std::size_t>(column)]; }

  /// Draws point i, and what lies between it and the next one where both are one surface.
  void draw(std::size_t i) {
    const std::int32_t own = columns_[i];
    nearest_at(own) = std::max(nearest_at(own), disparities_[i]);
    const bool goes_on =
        i + 1 < depths_.size() && depths_[i + 1] != 0.0f && std::abs(depths_[i + 1] - depths_[i]) <= jump_mm_;
    if (!goes_on) return;
    const std::int32_t next = columns_[i + 1];
    const float farther = std::min(disparities_[i], disparities_[i + 1]);
    for (std::int32_t column = std::min(own, next) + 1; column < std::max(own, next); ++column) {
      nearest_at(column) = std::max(nearest_at(column), farther);
    }
  }

  float focal_baseline_;
  float jump_mm_;
  std::span<const float> depths_;
  std::vector<float> disparities_;
  std::vector<std::int32_t> columns_;  ///< of the projector, in which each point is seen
  std::vector<float> nearest_;
};

}  // namespace

void StructuredLightOptions::visit(OptionVisitor& visitor) {
  visitor.real("baseline_mm", baseline_mm, closed(-1000, 1000));
  visitor.real("disparity_px", disparity_px, closed(0, 10));
  visitor.flag("shadows", shadows);
}

Image<float> without_shadows(Image<float> depth_mm, const Camera& camera,
                             const StructuredLightOptions& options, double jump_mm) {
  if (options.baseline_mm == 0.0 || !options.shadows) return depth_mm;
  const auto focal_baseline = static_cast<float>(camera.fx * options.baseline_mm);
  ProjectorRow projector(focal_baseline, static_cast<float>(jump_mm));
  std::vector<std::size_t> dark;
  for (int row = 0; row < depth_mm.height(); ++row) {
    const std::span<float> depths = depth_mm.row(row);
    if (std::ranges::all_of(depths, [](float depth) { return depth == 0.0f; })) continue;
    projector.see(depths);
    dark.clear();
    for (std::size_t i = 0; i < depths.size(); ++i) {
      if (depths[i] != 0.0f && projector.is_shadowed(i)) dark.push_back(i);
    }
    for (const std::size_t i : dark) depths[i] = 0.0f;
  }
  return depth_mm;
}

Image<float> with_rounded_disparity(Image<float> depth_mm, const Camera& camera,
                                    const StructuredLightOptions& options) {
  if (options.baseline_mm == 0.0 || options.disparity_px == 0.0) return depth_mm;
  const auto steps_mm = static_cast<float>(std::abs(camera.fx * options.baseline_mm) / options.disparity_px);
  for (float& depth : depth_mm.pixels()) {
    const float steps = depth == 0.0f ? 0.0f : std::nearbyint(steps_mm / depth);
    depth = steps == 0.0f ? 0.0f : steps_mm / steps;
  }
  return depth_mm;
}

}  // namespace knuckle
