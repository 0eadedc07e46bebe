// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/synth/pose/hand_sampler.h"
#include "knuckle/synth/pose/motion_options.h"
#include "knuckle/synth/scene/placement.h"

namespace knuckle {

/// Everything that postures are made of.
struct PostureOptions {
  HandPoseOptions hand;
  PlacementOptions placement;
  MotionOptions motion;
};

/// A hand of `sampled_hand` whose digits do not run into one another more than the options allow: the first
/// of up to 40, else the best.
HandAngles sampled_free_hand(const BodyRig& rig, const HandPoseOptions& options, Random& random);

/// Frames of a smooth motion that belong together: which sequence, and where in it. Without motion each frame
/// is a sequence of its own.
struct MotionPlace {
  std::int64_t sequence = 0;
  std::int64_t frame = 0;
};
/// Where frame `index`, from 0 on, lies among the sequences.
MotionPlace place_in_motion(const MotionOptions& options, std::int64_t index);

/// The posture of one frame: a function of its arguments alone. Without motion each index is a scene of its
/// own. Smooth: the person stands where `seed` says, and hand and arm go from one random posture to the next,
/// at rest at each. `held_hand`: what holds a thing keeps this shape.
PlacedPosture posture_of_frame(const BodyRig& rig, const Camera& camera, const PostureOptions& options,
                               std::uint64_t seed, std::int64_t index, const HandAngles* held_hand = nullptr);

}  // namespace knuckle
