// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "knuckle/patch/patch_extractor.h"
#include "knuckle/segment/mean_shift_segmenter.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

void patch_96(benchmark::State& state) {
  const Frame frame = testing::hand_frame(0);
  const Segmentation found = MeanShiftSegmenter(MeanShiftSegmenterOptions{}).segment(frame, std::nullopt, 1);
  if (found.hands.empty()) state.SkipWithError("no hand found");
  const PatchExtractor extractor(PatchOptions{96}, PatchStatistics{96, Image<float>(96, 96, 0.5f), {}});
  for ([[maybe_unused]] const auto step : state) {
    benchmark::DoNotOptimize(extractor.extract(frame, found.hands.front()));
  }
}
BENCHMARK(patch_96)->Name("patch/96")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace knuckle
