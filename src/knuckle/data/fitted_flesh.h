// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/data/frame_record.h"
#include "knuckle/hand/flesh_cone.h"

namespace knuckle {

/// The flesh around the landmarks of a hand, as it was fitted to its image; nothing where no hand model was
/// fitted to it, and no cones at landmarks that are not known.
std::vector<FleshCone> fitted_flesh(const HandRecord& hand);

}  // namespace knuckle
