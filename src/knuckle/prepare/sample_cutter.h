// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "knuckle/core/progress.h"
#include "knuckle/prepare/network_samples.h"

namespace knuckle {

/// Cuts training samples out of frames, one at a time: each depends on its frame alone, so a set may be made
/// in parts, in any order. Safe to call from many threads.
class SampleCutter {
 public:
  virtual ~SampleCutter() = default;
  /// Frames that samples can be cut out of.
  virtual std::int64_t frames() const = 0;
  enum class Outcome { used, without_hand, off_centre };
  /// Cuts a sample out of frame `index`, in [0, frames), and puts it at `place`, which stays as it is where
  /// the frame cannot be used.
  virtual Outcome cut(std::int64_t index, CubeSamples& to, std::int64_t place) const = 0;
};

/// Room for samples as the options say.
CubeSamples room_for_samples(std::int64_t count, const SampleOptions& options);

/// The samples of frames [first, first + count), on all threads.
NetworkSamples cut_samples(const SampleCutter& cutter, std::int64_t first, std::int64_t count,
                           const SampleOptions& options, Progress& progress);

/// Of hands, as `network_samples` cuts them out; `finder` has to live as long. Throws what that throws where
/// the source is of no use.
std::unique_ptr<SampleCutter> hand_cutter(const std::string& source, const HandFinder& finder,
                                          const SampleOptions& options);

}  // namespace knuckle
