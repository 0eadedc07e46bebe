// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/earlier_hands.h"

namespace knuckle {

EarlierHands::EarlierHands(const LabelBook& book) {
  for (const auto& [hand, history] : book.hands()) {
    if (has_landmarks(history.newest())) hands_.emplace(history.state() != LabelState::verified, hand);
  }
}

std::optional<HandKey> EarlierHands::take() {
  if (hands_.empty()) return std::nullopt;
  return hands_.extract(hands_.begin()).value().second;
}

bool EarlierHands::take(HandKey hand) {
  return hands_.erase({false, hand}) + hands_.erase({true, hand}) > 0;
}

}  // namespace knuckle
