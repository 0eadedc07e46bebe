// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/label/fitted_hands.h"

namespace knuckle {

/// The labels of a hand that follows verified ones, and the fit that they come from.
struct PropagatedHand {
  std::vector<LandmarkLabel> labels;  ///< one per landmark of the convention
  LabelFit fit;
};

/// The verified hands of its side and sequence that a hand follows, up to `reach` frames away: those before
/// it, then those after it, the nearest first. Throws an Error where the source cannot say the sequence of a
/// frame.
std::vector<HandKey> verified_around(HandKey hand, const LabelBook& book, const FittedHands& fits, int reach);

/// What a hand of `frame` is where it follows the verified hands around it that were fitted, whatever it was
/// before. Nothing where there are none, or nothing can be fitted. Throws an Error as `verified_around` does.
std::optional<PropagatedHand> following_hand(HandKey hand, const Frame& frame, const LabelBook& book,
                                             const FittedHands& fits, int reach);

/// What a hand of `frame` becomes where it follows the verified hands of its side and sequence, up to `reach`
/// frames away. Nothing where there are none, a person has touched it, nothing can be fitted, or it would
/// hardly move: less than 1 mm is not worth a line in the file. Throws an Error where the source cannot say
/// the sequence of a frame.
std::optional<PropagatedHand> propagated_hand(HandKey hand, const Frame& frame, const LabelBook& book,
                                              const FittedHands& fits, int reach);

}  // namespace knuckle
