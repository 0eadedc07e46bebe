// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "knuckle/prepare/sample_cutter.h"
#include "knuckle/prepare/sample_stream.h"

namespace knuckle {

/// Samples that are cut out of their frames each time that they are asked for, and kept nowhere: neither disk
/// nor memory, but work. Sample i is that of frame i; where it cannot be used, of the next one that can, of
/// the first after the last.
class FreshSamples final : public SampleStream {
 public:
  /// Looks at the first frames, to see what is labelled. Throws an Error that names the source where 1,024
  /// frames in a row cannot be used.
  FreshSamples(std::string source, std::unique_ptr<SampleCutter> cutter, const SampleOptions& options);

  std::int64_t size() const override { return runs_.front(); }
  const std::vector<std::int64_t>& runs() const override { return runs_; }
  /// All: what becomes of them is seen later.
  const SampleFrames& frames() const override { return frames_; }
  /// Of the first frames.
  const std::vector<bool>& known_joints() const override { return known_; }
  CubeSamples room_for(std::int64_t count) const override { return room_for_samples(count, options_); }
  /// On all threads.
  void fetch(std::span<const std::int64_t> numbers, CubeSamples& to, std::int64_t first) const override;

 private:
  void cut(std::int64_t number, CubeSamples& to, std::int64_t place) const;

  std::string source_;
  std::unique_ptr<SampleCutter> cutter_;
  SampleOptions options_;
  std::vector<std::int64_t> runs_;
  SampleFrames frames_;
  std::vector<bool> known_;
};

}  // namespace knuckle
