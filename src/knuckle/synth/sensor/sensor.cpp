// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/sensor.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "knuckle/synth/render/surface_angle.h"
#include "knuckle/synth/sensor/depth_edges.h"

namespace knuckle {
namespace {

/// A plane at that depth, parallel to the image, hides what lies behind it and fills the rest.
void add_wall(SeenSurfaces& surfaces, const Camera& camera, float wall_mm) {
  const Image<float> squares = squared_ray_lengths(camera);
  for (std::size_t i = 0; i < squares.size(); ++i) {
    float& depth = surfaces.depth_mm.data()[i];
    if (depth != 0.0f && depth <= wall_mm) continue;
    depth = wall_mm;
    if (!surfaces.cosines.empty()) surfaces.cosines.data()[i] = 1.0f / std::sqrt(squares.data()[i]);
  }
}

/// Lateral noise and flying pixels: what happens at depth edges only.
void blur_edges(SeenSurfaces& surfaces, const SensorOptions& options, std::uint64_t seed) {
  if (options.lateral.lateral_px == 0.0 && options.flying.flying_px == 0.0) return;
  const std::vector<std::int32_t> edges = edge_pixels(surfaces.depth_mm, options.jump_mm);
  Image<float>& depth_mm = surfaces.depth_mm;
  const auto moved = displaced_pixels(edges, depth_mm.width(), depth_mm.height(), options.lateral, seed);
  if (!moved.empty()) {
    depth_mm = displaced(depth_mm, moved);
    if (!surfaces.cosines.empty()) surfaces.cosines = displaced(surfaces.cosines, moved);
  }
  depth_mm = with_flying_pixels(depth_mm, edges, options.flying, seed);
}

/// Neighbours whose windows overlap err together.
RangeNoiseOptions noise_of_frame(const SensorOptions& options, std::uint64_t seed) {
  RangeNoiseOptions noise = options.noise;
  const double reach = drawn_window_px(options.matching, seed);
  const auto grain_px = static_cast<int>(std::lround(reach * options.matching.window_grain));
  noise.grain_px = std::max(noise.grain_px, grain_px);
  return noise;
}

Image<float> rounded(Image<float> depth_mm, double quantisation_mm) {
  const auto step = static_cast<float>(quantisation_mm);
  if (step == 0.0f) return depth_mm;
  for (float& depth : depth_mm.pixels()) depth = std::nearbyint(depth / step) * step;
  return depth_mm;
}

}  // namespace

void SensorOptions::visit(OptionVisitor& visitor) {
  visitor.real("background_mm", background_mm, closed(0, 10000));
  visitor.real("jump_mm", jump_mm, closed(1, 10000));
  structured_light.visit(visitor);
  matching.visit(visitor);
  lateral.visit(visitor);
  flying.visit(visitor);
  infrared.visit(visitor);
  noise.visit(visitor);
  drop_outs.visit(visitor);
  visitor.real("quantisation_mm", quantisation_mm, closed(0, 100));
}

bool SensorOptions::needs_angles() const {
  return infrared.infrared > 0.0 || noise.slant_mm > 0.0 || drop_outs.grazing_deg < 90.0;
}

std::optional<SensorFault> fault_of(const SensorOptions& options, const Camera& camera) {
  const DropOutOptions& limits = options.drop_outs;
  if (limits.range_mm > 0.0 && limits.near_mm >= limits.range_mm) {
    return SensorFault{"near_mm", fmt::format("is {}, expected a value below range_mm, {}", limits.near_mm,
                                              limits.range_mm)};
  }
  const StructuredLightOptions& light = options.structured_light;
  if (light.baseline_mm != 0.0 && camera.model != CameraModel::projective) {
    return SensorFault{"baseline_mm", "is not 0, but structured light needs a projective camera"};
  }
  if (light.disparity_px > 0.0 && light.baseline_mm == 0.0) {
    return SensorFault{"disparity_px",
                       "is not 0, but baseline_mm is: without a baseline there is no disparity"};
  }
  if (options.infrared.infrared_sigma > 0.0 && options.infrared.infrared == 0.0) {
    return SensorFault{"infrared_sigma", "is not 0, but infrared is: there is no image to be noisy"};
  }
  return std::nullopt;
}

void check(const SensorOptions& options, const Camera& camera, std::string_view what) {
  check_options(options, what);
  if (const auto fault = fault_of(options, camera)) fail("{}: {} {}", what, fault->key, fault->message);
}

SensorImages measured(SeenSurfaces surfaces, const Camera& camera, const SensorOptions& options,
                      std::uint64_t seed) {
  check(options, camera, "sensor");
  if (options.background_mm > 0.0) add_wall(surfaces, camera, static_cast<float>(options.background_mm));
  surfaces.depth_mm =
      without_shadows(std::move(surfaces.depth_mm), camera, options.structured_light, options.jump_mm);
  surfaces.depth_mm = matched_in_windows(surfaces.depth_mm, options.matching, options.jump_mm, seed);
  blur_edges(surfaces, options, seed);
  SensorImages images;
  if (options.infrared.infrared > 0.0) {
    images.infrared = infrared_image(surfaces.depth_mm, surfaces.cosines, camera, options.infrared, seed);
  }
  Image<float> depth_mm =
      with_range_noise(std::move(surfaces.depth_mm), surfaces.cosines, noise_of_frame(options, seed), seed);
  depth_mm = with_rounded_disparity(std::move(depth_mm), camera, options.structured_light);
  depth_mm = with_drop_outs(std::move(depth_mm), surfaces.cosines, options.drop_outs, seed);
  images.depth_mm = rounded(std::move(depth_mm), options.quantisation_mm);
  return images;
}

}  // namespace knuckle
