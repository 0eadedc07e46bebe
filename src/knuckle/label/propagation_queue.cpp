// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/propagation_queue.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace knuckle {

void PropagationQueue::add_neighbours(HandKey verified, const LabelBook& book) {
  add_neighbours(verified, book, std::numeric_limits<std::int64_t>::max());
}

/// Without hands that have followed after the change number `since`.
void PropagationQueue::add_neighbours(HandKey verified, const LabelBook& book, std::int64_t since) {
  std::array<bool, 2> goes_on{true, true};
  for (int away = 1; away <= reach_; ++away) {
    for (const int direction : {-1, 1}) {
      bool& goes = goes_on[direction < 0 ? 0 : 1];
      const HandKey other{verified.frame + direction * away, verified.side};
      goes = goes && other.frame >= 0 && other.frame < book.head().frames;
      if (!goes) continue;
      const HandHistory* const history = book.find(other);
      if (history != nullptr && history->state() == LabelState::verified) goes = false;
      if (history != nullptr && history->state() >= LabelState::corrected) continue;
      if (history != nullptr && history->last(LabelAct::propagate) > since) continue;
      if (!waiting_.insert(other).second) std::erase(hands_, other);
      hands_.push_back(other);
    }
  }
}

/// In the order in which they were verified, as the earlier session put them in.
void PropagationQueue::add_interrupted(const LabelBook& book) {
  std::vector<std::pair<std::int64_t, HandKey>> verified;
  for (const auto& [hand, history] : book.hands()) {
    const std::int64_t since = history.last(LabelAct::verify);
    if (since > 0 && history.state() == LabelState::verified) verified.emplace_back(since, hand);
  }
  std::ranges::sort(verified);
  for (const auto& [since, hand] : verified) add_neighbours(hand, book, since);
}

std::optional<HandKey> PropagationQueue::take() {
  if (hands_.empty()) return std::nullopt;
  const HandKey first = hands_.front();
  hands_.pop_front();
  waiting_.erase(first);
  return first;
}

}  // namespace knuckle
