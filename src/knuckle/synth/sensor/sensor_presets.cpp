// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/sensor_presets.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

/// A camera whose axis goes through the middle of the image.
Camera centred_camera(int width, int height, double fx, double fy) {
  return {.width = width,
          .height = height,
          .fx = fx,
          .fy = fy,
          .cx = 0.5 * (width - 1),
          .cy = 0.5 * (height - 1)};
}

SensorPreset paper() {
  return {centred_camera(320, 240, 224.0, 224.0), {}};
}

/// The paper's 3 mm at 0.4 m, growing to 8 mm at the end of the range (assumed).
SensorPreset creative() {
  SensorPreset preset = paper();
  preset.sensor.flying.flying_px = 1.0;
  preset.sensor.infrared = {.infrared = 1000.0, .infrared_sigma = 20.0};
  preset.sensor.noise = {.sigma_mm = 2.0, .growth_mm = 6.0, .slant_mm = 0.3, .grain_px = 2};
  preset.sensor.drop_outs = {.grazing_deg = 80.0, .near_mm = 150.0, .range_mm = 1000.0, .hole_share = 0.002};
  return preset;
}

/// 82 x 66 degrees: fx = 80 / tan 41, fy = 60 / tan 33.
SensorPreset pico() {
  SensorPreset preset = creative();
  preset.camera = centred_camera(160, 120, 92.03, 92.39);
  preset.sensor.infrared = {.infrared = 600.0, .infrared_sigma = 15.0};
  preset.sensor.noise = {.sigma_mm = 2.0, .growth_mm = 8.0, .slant_mm = 0.3, .grain_px = 1};
  return preset;
}

/// Baseline 75 mm, disparities in 1/8 px; random errors of half a step, 1.43 mm at 1 m (Khoshelham and Oude
/// Elberink 2012); angle and lateral noise of Nguyen, Izadi and Lovell 2012.
SensorPreset kinect_v1() {
  SensorPreset preset{centred_camera(640, 480, 585.0, 585.0), {}};
  preset.sensor.structured_light = {.baseline_mm = 75.0, .disparity_px = 0.125};
  preset.sensor.lateral.lateral_px = 0.35;
  preset.sensor.infrared = {.infrared = 500.0, .infrared_sigma = 20.0};
  preset.sensor.noise = {.sigma_mm = 0.0, .growth_mm = 1.43, .slant_mm = 0.1, .grain_px = 5};
  preset.sensor.drop_outs = {.grazing_deg = 75.0, .near_mm = 400.0, .range_mm = 4000.0, .hole_share = 0.001};
  return preset;
}

/// A RealSense D435 whose depth is aligned with its colour camera: f 610 px, baseline 50 mm, disparities in
/// 1/32 px (Keselman et al., "Intel RealSense stereoscopic depth cameras", CVPR workshops 2017), random
/// errors of 0.08 px, alike over about 6 px. The window is assumed.
SensorPreset d400() {
  SensorPreset preset{centred_camera(640, 480, 610.0, 610.0), {}};
  preset.sensor.structured_light = {.baseline_mm = 50.0, .disparity_px = 0.03125};
  preset.sensor.matching.window_px = 4;
  preset.sensor.lateral.lateral_px = 0.5;
  preset.sensor.infrared = {.infrared = 800.0, .infrared_sigma = 20.0};
  preset.sensor.noise = {.sigma_mm = 0.0, .growth_mm = 2.6, .slant_mm = 0.2, .grain_px = 6};
  preset.sensor.drop_outs = {.grazing_deg = 82.0, .near_mm = 150.0, .range_mm = 6000.0, .hole_share = 0.001};
  return preset;
}

/// Noise of Fankhauser et al. 2015, 1.5 - 0.5 z + 0.3 z^2 mm, near 0.7 m.
SensorPreset kinect_v2() {
  SensorPreset preset{centred_camera(512, 424, 365.0, 365.0), {}};
  preset.sensor.flying.flying_px = 1.0;
  preset.sensor.infrared = {.infrared = 2000.0, .infrared_sigma = 20.0};
  preset.sensor.noise = {.sigma_mm = 1.3, .growth_mm = 0.0, .slant_mm = 0.1, .grain_px = 2};
  preset.sensor.drop_outs = {.grazing_deg = 82.0, .near_mm = 500.0, .range_mm = 4500.0, .hole_share = 0.001};
  return preset;
}

/// Depths in 1/8 mm from 0.2 to 1.5 m (Zabatani et al. 2020). The projector's place is that at which the
/// shadows of SR305 recordings fit best.
SensorPreset sr300() {
  SensorPreset preset{centred_camera(640, 480, 475.0, 475.0), {}};
  preset.sensor.structured_light = {.baseline_mm = -50.0};
  preset.sensor.lateral.lateral_px = 0.2;
  preset.sensor.infrared = {.infrared = 800.0, .infrared_sigma = 20.0};
  preset.sensor.noise = {.sigma_mm = 0.2, .growth_mm = 1.5, .slant_mm = 0.1, .grain_px = 4};
  preset.sensor.drop_outs = {.grazing_deg = 75.0, .near_mm = 200.0, .range_mm = 1500.0, .hole_share = 0.002};
  preset.sensor.quantisation_mm = 0.125;
  return preset;
}

struct NamedPreset {
  std::string_view name;
  SensorPreset (*make)();
};
constexpr std::array<NamedPreset, 7> kPresets = {{{"paper", paper},
                                                  {"creative", creative},
                                                  {"pico", pico},
                                                  {"kinect_v1", kinect_v1},
                                                  {"kinect_v2", kinect_v2},
                                                  {"sr300", sr300},
                                                  {"d400", d400}}};

constexpr auto kNames = [] {
  std::array<std::string_view, kPresets.size()> names;
  std::ranges::transform(kPresets, names.begin(), &NamedPreset::name);
  return names;
}();

}  // namespace

std::span<const std::string_view> sensor_preset_names() {
  return kNames;
}

SensorPreset sensor_preset(std::string_view name) {
  for (const NamedPreset& preset : kPresets) {
    if (preset.name == name) return preset.make();
  }
  fail("no sensor is named '{}'; known: {}", name,
       joined(std::vector<std::string>(kNames.begin(), kNames.end())));
}

}  // namespace knuckle
