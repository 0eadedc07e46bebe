// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "knuckle/segment/forest_segmenter.h"
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
    const Segmentation found = segmenter.segment(frames[next++ % frames.size()], std::nullopt, 1);
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

/// Trees of random splits with 131,072 leaves each, uneven, at most 25 deep. A trained forest sends
/// neighbouring pixels the same way far longer than this one does.
PixelForest random_forest() {
  constexpr int kTrees = 4;
  constexpr int kLeaves = 1 << 17;
  constexpr int kMostDepth = 25;
  struct Pending {
    int leaves = 0;
    int depth = 0;
  };
  Random random(1);
  PixelForest::Parts parts;
  for (int tree = 0; tree < kTrees; ++tree) {
    const std::size_t root = parts.trees.nodes.size();
    parts.trees.roots.push_back(static_cast<std::uint32_t>(root));
    std::vector<Pending> nodes{{kLeaves, 0}};  // in the order of the tree's nodes
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto [leaves, depth] = nodes[i];
      if (leaves == 1 || depth == kMostDepth) {
        parts.trees.nodes.push_back({~static_cast<std::int32_t>(parts.leaf_codes.size()), {}, 0});
        parts.leaf_codes.push_back(static_cast<std::uint8_t>(random.below(256)));
        continue;
      }
      const DepthOffset first = drawn_offset({}, random);
      const DepthOffset second = drawn_offset({}, random);
      parts.trees.nodes.push_back({static_cast<std::int32_t>(root + nodes.size()),
                                   {first.x, first.y, second.x, second.y},
                                   static_cast<std::int16_t>(random.uniform(-20.0, 20.0))});
      const int left = std::clamp(static_cast<int>(leaves * random.uniform(0.2, 0.8)), 1, leaves - 1);
      nodes.push_back({left, depth + 1});
      nodes.push_back({leaves - left, depth + 1});
    }
  }
  return {std::move(parts), "bench"};
}

void forest_320x240(benchmark::State& state) {
  ForestSegmenterOptions options;
  options.probability = 0.4;  // the leaves are random: about half of the pixels pass
  segment_frames(state, ForestSegmenter(random_forest(), options));
}
BENCHMARK(forest_320x240)
    ->Name("segment/forest/320x240")
    ->Unit(benchmark::kMicrosecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

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
