// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "knuckle/eval/metrics/followed_hands.h"
#include "knuckle/eval/pictures/figures.h"

namespace knuckle {

/// The most hands that angle_figures draws.
inline constexpr std::size_t kMostAngleHands = 7;

/// A figure per joint angle: its course [degrees] in each followed hand that a hand model was fitted to, over
/// time where all frames know theirs and it rises throughout, over their numbers else. A frame in which
/// a hand was not fitted is a gap. Of many hands those with the most fitted frames are drawn, in the order in
/// which they appear; of long sequences every n-th frame, which the axis says. Empty where no hand was
/// fitted, or of a single frame.
std::vector<Figure> angle_figures(std::span<const NamedRecords> records);

}  // namespace knuckle
