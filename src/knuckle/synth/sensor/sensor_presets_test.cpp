// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/sensor_presets.h"

#include <cmath>
#include <numbers>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(SensorPresets, AllArePossible) {
  for (const std::string_view name : sensor_preset_names()) {
    const SensorPreset preset = sensor_preset(name);
    EXPECT_NO_THROW(check(preset.camera)) << name;
    EXPECT_NO_THROW(check(preset.sensor, preset.camera, name)) << name;
  }
}

TEST(SensorPresets, HaveTheSizesAndAnglesOfTheirCameras) {
  const auto degrees = [](int pixels, double focal_length) {
    return 2.0 * std::atan(0.5 * pixels / focal_length) * 180.0 / std::numbers::pi;
  };
  const Camera pico = sensor_preset("pico").camera;
  EXPECT_EQ(pico.width, 160);
  EXPECT_EQ(pico.height, 120);
  EXPECT_NEAR(degrees(pico.width, pico.fx), 82.0, 0.05);
  EXPECT_NEAR(degrees(pico.height, pico.fy), 66.0, 0.05);
  const Camera kinect_v2 = sensor_preset("kinect_v2").camera;
  EXPECT_NEAR(degrees(kinect_v2.width, kinect_v2.fx), 70.6, 0.8);
  EXPECT_NEAR(degrees(kinect_v2.height, kinect_v2.fy), 60.0, 0.8);
  const Camera sr300 = sensor_preset("sr300").camera;
  EXPECT_NEAR(degrees(sr300.width, sr300.fx), 68.0, 0.5);
  EXPECT_NEAR(degrees(sr300.height, sr300.fy), 54.0, 1.0);
  EXPECT_EQ(sensor_preset("creative").camera.fx, 224.0);
  EXPECT_EQ(sensor_preset("kinect_v1").camera.width, 640);
}

TEST(SensorPresets, PaperAddsThreeMillimetresOfNoiseOnly) {
  const SensorOptions sensor = sensor_preset("paper").sensor;
  EXPECT_EQ(options_as_toml(sensor), options_as_toml(SensorOptions{}));
  EXPECT_EQ(sensor.noise.sigma_mm, 3.0);
}

TEST(SensorPresets, AnUnknownOneIsRefusedWithAllNames) {
  const std::string message = testing::error_of([] { sensor_preset("kinect"); });
  for (const std::string_view name : sensor_preset_names()) {
    EXPECT_THAT(message, ::testing::HasSubstr(std::string(name)));
  }
}

}  // namespace
}  // namespace knuckle
