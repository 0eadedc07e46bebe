// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <atomic>
#include <numeric>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/random.h"
#include "knuckle/prepare/sample_cutter.h"
#include "knuckle/prepare/sample_stream.h"

namespace knuckle::testing {

/// Samples of one pixel's patch and a crop of 2 x 2, so that thousands are quick.
inline SampleOptions tiny_samples() {
  SampleOptions options;
  options.convention = convention_from_name("nyu14");
  options.patch = {1, 100.0};
  options.crop_px = 2;
  return options;
}

/// Cuts sample i out of no frame at all: what it holds follows from i.
class MadeUpCutter final : public SampleCutter {
 public:
  /// Every `unused`-th frame cannot be used; 0: all can.
  explicit MadeUpCutter(std::int64_t frames, std::int64_t unused = 0) : frames_(frames), unused_(unused) {}

  std::int64_t frames() const override { return frames_; }
  Outcome cut(std::int64_t index, CubeSamples& to, std::int64_t place) const override {
    ++cuts;
    if (index == breaks_at) fail("frame {} breaks", index);
    if (unused_ > 0 && index % unused_ == 0)
      return index % 2 == 0 ? Outcome::without_hand : Outcome::off_centre;
    Random random(7, static_cast<std::uint64_t>(index));
    std::vector<std::uint8_t> codes(static_cast<std::size_t>(to.crop_px()) * to.crop_px());
    for (std::uint8_t& code : codes) code = static_cast<std::uint8_t>(random.below(256));
    std::vector<float> joints(3 * static_cast<std::size_t>(to.joint_count()));
    for (float& number : joints) number = static_cast<float>(random.uniform());
    for (std::size_t i = 0; i < 3; ++i) joints[i] = static_cast<float>(kNaN);  // nobody knows the first
    to.set(place, {codes, joints, Point3(0, 0, static_cast<double>(index))});
    return Outcome::used;
  }

  mutable std::atomic<std::int64_t> cuts = 0;
  std::int64_t breaks_at = -1;

 private:
  std::int64_t frames_;
  std::int64_t unused_;
};

/// Samples in memory as if they were on a disk, in runs.
class MemoryStream final : public SampleStream {
 public:
  MemoryStream(const CubeSamples& samples, std::vector<std::int64_t> runs)
      : samples_(samples),
        runs_(std::move(runs)),
        frames_{samples.size(), 0, 0},
        known_(knuckle::known_joints(samples)) {}

  std::int64_t size() const override { return samples_.size(); }
  const std::vector<std::int64_t>& runs() const override { return runs_; }
  const SampleFrames& frames() const override { return frames_; }
  const std::vector<bool>& known_joints() const override { return known_; }
  CubeSamples room_for(std::int64_t count) const override {
    return {count, samples_.joint_count(), samples_.patch(), samples_.crop_px()};
  }
  void fetch(std::span<const std::int64_t> numbers, CubeSamples& to, std::int64_t first) const override {
    for (const std::int64_t number : numbers) {
      if (number == breaks_at) fail("sample {} breaks", number);
      fetched += 1;
      if (number != leaves_out) to.set(first, samples_.sample(number));
      ++first;
    }
  }

  std::int64_t breaks_at = -1;
  std::int64_t leaves_out = -1;
  mutable std::atomic<std::int64_t> fetched = 0;

 private:
  const CubeSamples& samples_;
  std::vector<std::int64_t> runs_;
  SampleFrames frames_;
  std::vector<bool> known_;
};

}  // namespace knuckle::testing
