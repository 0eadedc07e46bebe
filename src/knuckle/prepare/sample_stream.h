// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/prepare/cube_samples.h"
#include "knuckle/prepare/network_samples.h"

namespace knuckle {

/// Training samples that are not in memory, numbered from 0: those that are asked for are fetched. Safe to be
/// used by many threads at once.
class SampleStream {
 public:
  virtual ~SampleStream() = default;
  /// Number of samples.
  virtual std::int64_t size() const = 0;
  /// Sizes of the runs of samples that lie together, in the order of their numbers: they are fetched best
  /// together. One run of all where each is reached alike.
  virtual const std::vector<std::int64_t>& runs() const = 0;
  /// What became of the frames.
  virtual const SampleFrames& frames() const = 0;
  /// Which joints are known in at least one sample, joint by joint.
  virtual const std::vector<bool>& known_joints() const = 0;
  /// Room for samples of these sizes.
  virtual CubeSamples room_for(std::int64_t count) const = 0;
  /// Sets the places from `first` on of `to` to the samples of these numbers, which rise. Throws an Error
  /// where one cannot be had, and Interrupted.
  virtual void fetch(std::span<const std::int64_t> numbers, CubeSamples& to, std::int64_t first) const = 0;
};

}  // namespace knuckle
