// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "knuckle/label/fitted_hands.h"

namespace knuckle {

/// How a frame stands, for the film strip.
struct FrameStanding {
  std::optional<LabelState> state;  ///< the least of its hands'; nothing: there are no labels
  double doubt_mm = 0.0;  ///< how far its labels may be off: what the fit says of those not verified
};

/// One per frame of the source.
std::vector<FrameStanding> frame_standings(const LabelBook& book, const FittedHands& fits);

/// The frame whose correction would change most: its doubt, times the frames around it, up to `reach` on both
/// sides, that would follow. The next after `after` that is not verified where nothing is known; nothing
/// where all are verified.
std::optional<std::int64_t> proposed_frame(const std::vector<FrameStanding>& standings, std::int64_t after,
                                           int reach);

}  // namespace knuckle
