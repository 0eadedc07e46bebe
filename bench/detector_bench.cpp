// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "knuckle/segment/detector/detector_relief.h"
#include "knuckle/segment/detector/detector_segmenter.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

const Point3 kPalm(0, 0, 550);

/// A hand and its arm before a wall, with noise: every one of 640 x 480 pixels is measured.
Frame measured_frame() {
  Camera camera = testing::quarter_vga_camera();
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 575.0;
  camera.cx = 319.5;
  camera.cy = 239.5;
  Frame frame = testing::blank_frame(camera);
  Random random(1);
  testing::draw_hand(frame, kPalm, random);
  for (float& depth : frame.depth_mm.pixels()) {
    if (!is_measured(depth)) depth = 1500.0f;
    depth += static_cast<float>(3.0 * random.normal());
  }
  return frame;
}

/// As pipelines/train_detector_relief.toml has it.
constexpr DetectorOptions kWithRelief{.eighth_channels = 64, .sixteenth_channels = 128, .relief = true};

/// From frame to region; the weights say nothing of the time.
void detector_640x480(benchmark::State& state) {
  const Frame frame = measured_frame();
  const DetectedHand hand{.centre = kPalm, .extent_mm = 100.0, .score = 0.9};
  const DetectorSegmenter segmenter(testing::constant_detector({}, frame.camera, hand), {});
  for ([[maybe_unused]] const auto step : state) {
    const Segmentation found = segmenter.segment(frame, std::nullopt, 1);
    if (found.hands.empty()) state.SkipWithError("no hand found");
    benchmark::DoNotOptimize(found.hands.data());
  }
}
BENCHMARK(detector_640x480)->Name("segment/detector/640x480")->Unit(benchmark::kMicrosecond);

void shrink_640x480(benchmark::State& state) {
  const Frame frame = measured_frame();
  const DetectorView view({}, frame.camera);
  for ([[maybe_unused]] const auto step : state) benchmark::DoNotOptimize(view.shrink(frame.depth_mm));
}
BENCHMARK(shrink_640x480)->Name("segment/detector/shrink/640x480")->Unit(benchmark::kMicrosecond);

void relief(benchmark::State& state) {
  const Frame frame = measured_frame();
  const Image<float> inverse_depth =
      DetectorView(kWithRelief, frame.camera).shrink(frame.depth_mm).inverse_depth;
  std::vector<float> reliefs(kReliefInputs * inverse_depth.size());
  for ([[maybe_unused]] const auto step : state) {
    write_reliefs(kWithRelief, inverse_depth.pixels(), reliefs);
    benchmark::DoNotOptimize(reliefs.data());
  }
}
BENCHMARK(relief)->Name("segment/detector/relief")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace knuckle
