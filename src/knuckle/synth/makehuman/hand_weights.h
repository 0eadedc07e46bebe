// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/hand/body.h"
#include "knuckle/synth/makehuman/hand_anatomy.h"

namespace knuckle {

/// Spreads each vertex's share of a hand anew over the hand's bones, by bone heat from where the joint
/// regressors put them; what the arm holds stays. `vertices` is the shape [mm] on which distances are
/// measured.
void spread_hand_weights(Body& body, const HandOfBody& hand, const std::vector<Eigen::Vector3f>& vertices);

}  // namespace knuckle
