// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/fresh_samples.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"

namespace knuckle {
namespace {

constexpr std::int64_t kMostTries = 1024;
constexpr std::int64_t kLookedAt = 64;

}  // namespace

FreshSamples::FreshSamples(std::string source, std::unique_ptr<SampleCutter> cutter,
                           const SampleOptions& options)
    : source_(std::move(source)),
      cutter_(std::move(cutter)),
      options_(options),
      runs_{cutter_->frames()},
      frames_{cutter_->frames(), 0, 0} {
  std::vector<std::int64_t> first(static_cast<std::size_t>(std::min(size(), kLookedAt)));
  std::iota(first.begin(), first.end(), std::int64_t{0});
  CubeSamples samples = room_for(std::ssize(first));
  fetch(first, samples, 0);
  samples.finish();
  known_ = knuckle::known_joints(samples);
}

void FreshSamples::fetch(std::span<const std::int64_t> numbers, CubeSamples& to, std::int64_t first) const {
  parallel_for(std::ssize(numbers),
               [&](std::int64_t i) { cut(numbers[static_cast<std::size_t>(i)], to, first + i); });
}

void FreshSamples::cut(std::int64_t number, CubeSamples& to, std::int64_t place) const {
  const std::int64_t tries = std::min(kMostTries, size());
  for (std::int64_t i = 0; i < tries; ++i) {
    if (cutter_->cut((number + i) % size(), to, place) == SampleCutter::Outcome::used) return;
  }
  fail("{}: none of {} frames from frame {} on can be used: no labels, or no hand that segmentation finds",
       source_, tries, number);
}

}  // namespace knuckle
