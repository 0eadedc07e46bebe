// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/sample_cutter.h"

#include <atomic>

#include "knuckle/core/parallel.h"

namespace knuckle {

CubeSamples room_for_samples(std::int64_t count, const SampleOptions& options) {
  return {count, options.convention.size(), options.patch, options.crop_px};
}

NetworkSamples cut_samples(const SampleCutter& cutter, std::int64_t first, std::int64_t count,
                           const SampleOptions& options, Progress& progress) {
  CubeSamples samples = room_for_samples(count, options);
  std::atomic<std::int64_t> without_hand = 0;
  std::atomic<std::int64_t> off_centre = 0;
  parallel_for(count, [&](std::int64_t i) {
    const SampleCutter::Outcome outcome = cutter.cut(first + i, samples, i);
    if (outcome == SampleCutter::Outcome::without_hand) ++without_hand;
    if (outcome == SampleCutter::Outcome::off_centre) ++off_centre;
    progress.advance();
  });
  samples.finish();
  return {std::move(samples), {count, without_hand, off_centre}};
}

}  // namespace knuckle
