// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/hand/hand_skeleton.h"
#include "knuckle/synth/scene/shapes.h"

namespace knuckle {

/// The ways to hold a thing (after Feix et al., "The GRASP taxonomy of human grasp types", 2016): cylinder,
/// box and ball in the whole hand; pinch and tripod between finger tips and thumb; lateral between thumb and
/// the index finger's side; hook; palm, where it lies on the open hand.
std::span<const std::string_view> grasp_names();

/// A hand that holds a thing.
struct Grasp {
  HandAngles hand;
  Shape thing;
  RigidTransform hand_from_thing = RigidTransform::Identity();  ///< in the hand's axes, as HandSkeleton's
  bool lies_on_hand = false;  ///< held by its weight alone: only where the palm looks up
};

/// How far a thing is from the nearest flesh of a hand [mm]; negative: how deep that presses in. Both in the
/// hand's axes.
double gap_to_thing_mm(const std::array<Point3, kSupersetSize>& landmarks, const Grasp& grasp);

/// A thing of random size in a hand that has closed on it: fingers bend, from the palm outwards, until they
/// touch. No flesh presses in by more than 4 mm. `names`: which grasps may be drawn; empty: all. Nothing
/// where 8 random ones do not fit.
std::optional<Grasp> sampled_grasp(const HandSkeleton& skeleton, const std::vector<std::string>& names,
                                   Random& random);

}  // namespace knuckle
