// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "knuckle/core/frame.h"
#include "knuckle/hand/hand_surface.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/track/hand_track.h"

namespace knuckle {

/// What a frame shows of an estimated hand, as of a right one: a left one in a mirror.
struct RightHandSight {
  LandmarkTargets targets;  ///< the estimated landmarks
  HandSurface surface;      ///< what was measured near them
};

/// What `frame` shows of the hand that was estimated in it.
RightHandSight right_hand_sight(const Frame& frame, const HandEstimate& estimate);

/// The skeleton fitted to what a frame shows at `now_s` [s], from the track's last pose on, of the size and
/// proportions of `person`. In the first `learn_s` seconds `person` learns from it: each frame is then asked
/// for its own first, so that none is taken for what the first ones said. Nothing where too few landmarks are
/// known.
std::optional<SkeletonFit> fit_track(const HandTrack& track, const RightHandSight& sight, double now_s,
                                     double learn_s, PersonHand& person);

/// Whether the hand would have turned faster than hands do, from when the track was last believed to `next`
/// at `now_s` [s]: an estimate that sees a hand the wrong way about. What is said for long is believed.
bool turns_too_fast(const HandTrack& track, const SkeletonPose& next, double now_s);

/// In place of an estimate that turns a hand too fast: the track's last pose drawn to what the frame shows
/// near it. Nothing where that lies elsewhere, or clearly worse on what was measured.
std::optional<SkeletonFit> fit_where_it_was(const HandTrack& track, const SkeletonFit& estimated,
                                            const Frame& frame, double now_s);

}  // namespace knuckle
