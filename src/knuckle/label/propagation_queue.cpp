// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/propagation_queue.h"

#include <array>

namespace knuckle {

void PropagationQueue::add_neighbours(HandKey verified, const LabelBook& book) {
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
      std::erase(hands_, other);
      hands_.push_back(other);
    }
  }
}

std::optional<HandKey> PropagationQueue::take() {
  if (hands_.empty()) return std::nullopt;
  const HandKey first = hands_.front();
  hands_.pop_front();
  return first;
}

}  // namespace knuckle
