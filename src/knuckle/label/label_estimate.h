// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "knuckle/label/label_change.h"

namespace knuckle {

/// A hand that an estimator found, for labelling to begin with.
struct EstimatedHand {
  HandSide side = HandSide::right;
  HandPose pose;  ///< in any convention
};
/// What finds the hands of a frame; called without a lock, by one thread at a time.
using EstimateHands = std::function<std::vector<EstimatedHand>(const Frame&)>;

/// The labels that hands of a frame begin with: one change per side, of the first hand of that side, in the
/// convention of the labels. All landmarks are visible: what is hidden a person says. A machine's guess would
/// make good estimates count for nothing.
std::vector<LabelChange> estimated_changes(std::int64_t frame, const std::vector<EstimatedHand>& hands,
                                           const Convention& convention, const std::string& author,
                                           const std::string& time);

}  // namespace knuckle
