// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/frame_standing.h"

#include <algorithm>

namespace knuckle {

std::vector<FrameStanding> frame_standings(const LabelBook& book, const FittedHands& fits) {
  std::vector<FrameStanding> standings(static_cast<std::size_t>(book.head().frames));
  for (const auto& [hand, history] : book.hands()) {
    if (!is_labelled(history.newest())) continue;
    FrameStanding& standing = standings[static_cast<std::size_t>(hand.frame)];
    const LabelState state = history.state();
    standing.state = std::min(standing.state.value_or(state), state);
    if (state != LabelState::verified) standing.doubt_mm = std::max(standing.doubt_mm, fits.doubt_mm(hand));
  }
  return standings;
}

std::optional<std::int64_t> proposed_frame(const std::vector<FrameStanding>& standings, std::int64_t after,
                                           int reach) {
  const auto count = static_cast<std::int64_t>(standings.size());
  const auto is_open = [&](std::int64_t i) {
    return i >= 0 && i < count && standings[static_cast<std::size_t>(i)].state != LabelState::verified;
  };
  std::optional<std::int64_t> best;
  double most = -1.0;
  for (std::int64_t step = 1; step <= count; ++step) {
    const std::int64_t i = (after + step) % count;
    if (!is_open(i)) continue;
    double followers = 1.0;
    for (int away = 1; away <= reach; ++away) {
      for (const std::int64_t other : {i - away, i + away})
        followers += is_open(other) ? 1.0 / (1.0 + away) : 0.0;
    }
    const double gain = standings[static_cast<std::size_t>(i)].doubt_mm * followers;
    if (gain <= most) continue;
    most = gain;
    best = i;
  }
  return best;
}

}  // namespace knuckle
