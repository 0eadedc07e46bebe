// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "knuckle/segment/mean_shift_segmenter.h"
#include "knuckle/segment/nearest_pixel.h"
#include "knuckle/segment/testing.h"
#include "knuckle/segment/threshold_segmenter.h"

namespace knuckle {
namespace {

/// Frames of 320 x 240 pixels with 20,000 measured ones: a hand, its arm and a part of the body, with noise.
std::vector<Frame> made_up_frames() {
  std::vector<Frame> frames;
  for (std::uint64_t seed = 0; seed < 8; ++seed) frames.push_back(testing::hand_frame(seed, 20000));
  return frames;
}

template <class Method>
void segment_frames(benchmark::State& state, const Method& segmenter) {
  const std::vector<Frame> frames = made_up_frames();
  std::size_t next = 0;
  for ([[maybe_unused]] const auto step : state) {
    const Segmentation found = segmenter.segment(frames[next++ % frames.size()], std::nullopt);
    if (found.hands.empty()) state.SkipWithError("no hand found");
    benchmark::DoNotOptimize(found.hands.data());
  }
}

void mean_shift_320x240(benchmark::State& state) {
  segment_frames(state, MeanShiftSegmenter(MeanShiftSegmenterOptions{}));
}
BENCHMARK(mean_shift_320x240)->Name("segment/mean_shift/320x240")->Unit(benchmark::kMicrosecond);

void threshold_320x240(benchmark::State& state) {
  segment_frames(state, ThresholdSegmenter(ThresholdSegmenterOptions{}));
}
BENCHMARK(threshold_320x240)->Name("segment/threshold/320x240")->Unit(benchmark::kMicrosecond);

void nearest_pixel_320x240(benchmark::State& state) {
  const Frame frame = testing::hand_frame(0, 20000);
  for ([[maybe_unused]] const auto step : state) benchmark::DoNotOptimize(nearest_pixel(frame.depth_mm));
}
BENCHMARK(nearest_pixel_320x240)->Name("segment/nearest_pixel/320x240")->Unit(benchmark::kMicrosecond);

void points_around_320x240(benchmark::State& state) {
  const Frame frame = testing::hand_frame(0, 20000);
  const RayTable rays(frame.camera);
  for ([[maybe_unused]] const auto step : state) {
    benchmark::DoNotOptimize(points_around(frame.depth_mm, rays, Point3(0, 0, 500), 284.0).size());
  }
}
BENCHMARK(points_around_320x240)->Name("segment/points_around/320x240")->Unit(benchmark::kMicrosecond);

void kernel_sums_20000(benchmark::State& state) {
  const Frame frame = testing::hand_frame(0, 20000);
  const PointCloud cloud = points_around(frame.depth_mm, RayTable(frame.camera), Point3(0, 0, 500), 1e4);
  for ([[maybe_unused]] const auto step : state) {
    benchmark::DoNotOptimize(kernel_sums(cloud, Point3(0, 0, 500), 13.5));
  }
}
BENCHMARK(kernel_sums_20000)->Name("segment/kernel_sums/20000")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace knuckle
