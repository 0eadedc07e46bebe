// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/sensor/sensor.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/synth/sensor/sensor_presets.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;

const Camera kCamera{.width = 64, .height = 48, .fx = 60, .fy = 60, .cx = 31.5, .cy = 23.5};

SensorOptions silent() {
  SensorOptions options;
  options.noise.sigma_mm = 0.0;
  options.quantisation_mm = 0.0;
  return options;
}

Image<float> depth_of(const Image<float>& depth_mm, const SensorOptions& options, std::uint64_t seed = 1) {
  Camera camera = kCamera;
  camera.width = depth_mm.width();
  camera.height = depth_mm.height();
  return measured({depth_mm, {}}, camera, options, seed).depth_mm;
}

/// A hand-sized block before a wall, all with made-up angles.
SeenSurfaces block_before_wall() {
  SeenSurfaces surfaces{Image<float>(64, 48, 700.0f), Image<float>(64, 48, 0.9f)};
  for (int row = 15; row < 35; ++row) {
    for (int column = 20; column < 45; ++column) {
      surfaces.depth_mm(column, row) = 450.0f;
      surfaces.cosines(column, row) = 0.7f;
    }
  }
  return surfaces;
}

/// Every effect at once.
SensorOptions everything() {
  SensorOptions options;
  options.background_mm = 900.0;
  options.structured_light = {.baseline_mm = 60.0, .disparity_px = 0.1};
  options.lateral.lateral_px = 0.7;
  options.flying.flying_px = 1.0;
  options.infrared = {.infrared = 1000.0, .infrared_sigma = 10.0};
  options.noise = {.sigma_mm = 1.0, .growth_mm = 2.0, .slant_mm = 0.2};
  options.drop_outs = {.grazing_deg = 80.0, .near_mm = 100.0, .range_mm = 1000.0, .hole_share = 0.05};
  return options;
}

TEST(Sensor, IsAFunctionOfSceneAndSeed) {
  const SensorImages once = measured(block_before_wall(), kCamera, everything(), 3);
  const SensorImages again = measured(block_before_wall(), kCamera, everything(), 3);
  EXPECT_EQ(once.depth_mm, again.depth_mm);
  EXPECT_EQ(once.infrared, again.infrared);
  const SensorImages other = measured(block_before_wall(), kCamera, everything(), 4);
  EXPECT_NE(once.depth_mm, other.depth_mm);
  EXPECT_NE(once.infrared, other.infrared);
}

TEST(Sensor, EachEffectCanBeSwitchedOffAlone) {
  const SensorOptions all = everything();
  const auto without = [&](const auto& change) {
    SensorOptions options = all;
    change(options);
    return options;
  };
  const SensorOptions fewer[] = {without([](SensorOptions& o) { o.structured_light.disparity_px = 0; }),
                                 without([](SensorOptions& o) { o.structured_light.shadows = false; }),
                                 without([](SensorOptions& o) { o.lateral.lateral_px = 0; }),
                                 without([](SensorOptions& o) { o.flying.flying_px = 0; }),
                                 without([](SensorOptions& o) { o.noise.growth_mm = 0; }),
                                 without([](SensorOptions& o) { o.noise.slant_mm = 0; }),
                                 without([](SensorOptions& o) { o.drop_outs.hole_share = 0; }),
                                 without([](SensorOptions& o) { o.quantisation_mm = 0; })};
  const SensorImages full = measured(block_before_wall(), kCamera, all, 3);
  for (const SensorOptions& options : fewer) {
    EXPECT_NE(measured(block_before_wall(), kCamera, options, 3).depth_mm, full.depth_mm);
  }
}

TEST(Sensor, AllOffIsExact) {
  const SeenSurfaces surfaces = block_before_wall();
  const SensorImages images = measured(surfaces, kCamera, silent(), 3);
  EXPECT_EQ(images.depth_mm, surfaces.depth_mm);
  EXPECT_TRUE(images.infrared.empty());
}

TEST(Sensor, DefaultIsThePaper) {
  const Image<float> noisy = depth_of(Image<float>(400, 300, 700.0f), {});
  double squares = 0.0;
  for (const float depth : noisy.pixels()) {
    EXPECT_EQ(depth, std::nearbyint(depth));
    squares += (depth - 700.0) * (depth - 700.0) / noisy.size();
  }
  EXPECT_NEAR(std::sqrt(squares), std::sqrt(9.0 + 1.0 / 12.0), 0.03);
  const Image<float> nothing(33, 7);
  EXPECT_EQ(depth_of(nothing, {}), nothing);
}

TEST(Sensor, NoiseIsAlikeOverTheWindowsOfAFrame) {
  SensorOptions options = silent();
  options.noise.sigma_mm = 3.0;
  options.matching = {.window_px = 5, .window_grain = 2.0};
  SensorOptions grained = silent();
  grained.noise = {.sigma_mm = 3.0, .grain_px = 10};
  const Image<float> flat(64, 48, 700.0f);
  const Image<float> windows = depth_of(flat, options);
  const Image<float> grains = depth_of(flat, grained);
  for (std::size_t i = 0; i < flat.size(); ++i) EXPECT_NEAR(windows.data()[i], grains.data()[i], 1e-3f);
  options.matching.window_share = 0.0;  // no windows: every pixel has noise of its own
  SensorOptions single = silent();
  single.noise.sigma_mm = 3.0;
  EXPECT_EQ(depth_of(flat, options), depth_of(flat, single));
}

TEST(Sensor, RoundsToWholeSteps) {
  SensorOptions options;
  options.noise.sigma_mm = 5.0;
  options.quantisation_mm = 2.5;
  const Image<float> image = depth_of(Image<float>(64, 48, 433.3f), options);
  for (const float depth : image.pixels()) {
    EXPECT_EQ(depth, std::nearbyint(depth / 2.5f) * 2.5f);
  }
}

TEST(Sensor, AWallHidesWhatLiesBehindItAndFillsTheRest) {
  Image<float> image(4, 1);
  image(0, 0) = 500.0f;
  image(1, 0) = 900.0f;
  SensorOptions options = silent();
  options.background_mm = 800.0;
  const Image<float> walled = depth_of(image, options);
  EXPECT_EQ(walled(0, 0), 500.0f);
  for (const int column : {1, 2, 3}) EXPECT_EQ(walled(column, 0), 800.0f);
}

TEST(Sensor, AWallIsSeenAtTheAngleOfItsPlace) {
  SensorOptions options = silent();
  options.background_mm = 1000.0;
  options.infrared.infrared = 1000.0;
  const auto image = measured({Image<float>(64, 48), Image<float>(64, 48)}, kCamera, options, 1).infrared;
  const double x = 31.5 / 60;
  const double y = 23.5 / 60;
  const double ray = std::sqrt(1 + x * x + y * y);  // cosine 1 / ray, distance ray
  EXPECT_NEAR(image(0, 0), 1000.0 / (ray * ray * ray), 1.0);
}

TEST(Sensor, ShadowsAreDarkInTheInfraredImageToo) {
  SensorOptions options = silent();
  options.structured_light.baseline_mm = 100.0;
  options.infrared.infrared = 1000.0;
  const SensorImages images = measured(block_before_wall(), kCamera, options, 1);
  int dark = 0;
  for (std::size_t i = 0; i < images.depth_mm.size(); ++i) {
    EXPECT_EQ(images.depth_mm.data()[i] == 0.0f, images.infrared.data()[i] == 0);
    dark += images.depth_mm.data()[i] == 0.0f ? 1 : 0;
  }
  EXPECT_NEAR(dark / 20.0, 60 * 100 * (1 / 450.0 - 1 / 700.0), 1.5);  // 20 rows
}

TEST(Sensor, EveryPresetGivesAPictureWithinItsRange) {
  for (const std::string_view name : sensor_preset_names()) {
    const SensorPreset preset = sensor_preset(name);
    const int width = preset.camera.width;
    const int height = preset.camera.height;
    const SeenSurfaces surfaces{Image<float>(width, height, 600.0f), Image<float>(width, height, 0.9f)};
    const SensorImages images = measured(surfaces, preset.camera, preset.sensor, 1);
    const auto measured_pixels = std::ranges::count_if(
        images.depth_mm.pixels(), [](float depth) { return std::abs(depth - 600.0f) < 30.0f; });
    EXPECT_GT(measured_pixels, 0.98 * width * height) << name;
    EXPECT_EQ(images.infrared.empty(), name == "paper") << name;
  }
}

TEST(Sensor, RefusesImpossibleOptions) {
  const auto message_of = [](const auto& change) {
    SensorOptions options;
    change(options);
    return testing::error_of([&] { check(options, kCamera, "here"); });
  };
  const auto expect_refused = [&](const auto& change, const char* key) {
    EXPECT_THAT(message_of(change), HasSubstr(std::string("here: ") + key)) << key;
  };
  expect_refused([](SensorOptions& o) { o.noise.sigma_mm = -1; }, "sigma_mm");
  expect_refused([](SensorOptions& o) { o.noise.growth_mm = -1; }, "growth_mm");
  expect_refused([](SensorOptions& o) { o.noise.slant_mm = NAN; }, "slant_mm");
  expect_refused([](SensorOptions& o) { o.flying.flying_px = 3; }, "flying_px");
  expect_refused([](SensorOptions& o) { o.lateral.lateral_px = -1; }, "lateral_px");
  expect_refused([](SensorOptions& o) { o.jump_mm = 0; }, "jump_mm");
  expect_refused([](SensorOptions& o) { o.drop_outs.grazing_deg = 91; }, "grazing_deg");
  expect_refused([](SensorOptions& o) { o.drop_outs.hole_share = 1.5; }, "hole_share");
  expect_refused([](SensorOptions& o) { o.drop_outs = {.near_mm = 500, .range_mm = 400}; }, "near_mm");
  expect_refused([](SensorOptions& o) { o.structured_light.disparity_px = 0.1; }, "disparity_px");
  expect_refused([](SensorOptions& o) { o.infrared.infrared_sigma = 5; }, "infrared_sigma");
  expect_refused([](SensorOptions& o) { o.infrared.infrared = -5; }, "infrared");
  SensorOptions light;
  light.structured_light.baseline_mm = 75;
  Camera orthographic = kCamera;
  orthographic.model = CameraModel::orthographic;
  EXPECT_THAT(testing::error_of([&] { check(light, orthographic, "here"); }), HasSubstr("projective"));
}

}  // namespace
}  // namespace knuckle
