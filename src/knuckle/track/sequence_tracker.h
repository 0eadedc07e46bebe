// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "knuckle/pipeline/estimate_each.h"
#include "knuckle/track/tracker.h"

namespace knuckle {

/// Follows hands through frames that come in order. Each sequence stands for itself, ids included, so that it
/// does not matter which of them was seen before. For one thread at a time.
class SequenceTracker {
 public:
  /// With the pipeline's tracker; the pipeline has to live as long. Throws an Error where it has none.
  explicit SequenceTracker(const Pipeline& pipeline);

  /// The hands in the next frame, with ids, angles and skeleton, surest first.
  FrameResult follow(std::int64_t index, const Frame& frame);

 private:
  Tracker tracker_;
  std::optional<int> sequence_;
};

}  // namespace knuckle
