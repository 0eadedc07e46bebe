// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/hand/skeleton_fit.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/pipeline/tracker_options.h"
#include "knuckle/track/hands_apart.h"

namespace knuckle {

struct HandTrack;

/// One hand that is followed.
struct TrackedHand {
  int id = 0;  ///< from 1 on, never used again until `reset`
  HandSide side = HandSide::right;
  HandPose pose;       ///< in the image; its landmarks are the skeleton's, bones never change their length
  double score = 0.0;  ///< of the estimate that the fit began with, times how plausible the fit is, [0, 1]
  HandAngles angles;   ///< smoothed
  RigidTransform camera_from_hand =
      RigidTransform::Identity();  ///< of a right hand in the mirror, where it is a left one
  double size = 1.0;               ///< of the skeleton, against an adult's
  DigitNumbers lengths = kOnes;    ///< of its digits' bones besides, against an adult's
  std::string skeleton = "adult";  ///< its name
};

/// Follows hands from frame to frame: identities, sides, and a skeleton of constant bones fitted to each
/// estimate.
///
/// A hand is looked for where it was, moved by its velocity; all of the frame is searched only where a hand
/// is missing, and now and then for new ones. What such searches do not find again gives its place to what
/// they find.
/// A skeleton is fitted to the estimated landmarks and to the depth image from where it was in the last
/// frame; its size and the lengths of its digits are learned over the first seconds. The result is smoothed.
///
/// Times come from `Frame::time_s`; without them, frames are a thirtieth of a second apart. Where time goes
/// back, stands still or leaps by more than a second, or `Frame::sequence` changes, all hands are forgotten:
/// ids go on, though. Called by one thread at a time: a second one gets an Error, as does an estimator that
/// calls it. The pipeline has to live as long.
class Tracker {
 public:
  /// Throws an Error where an option is out of range.
  Tracker(const Pipeline& pipeline, const TrackerOptions& options);
  ~Tracker();
  Tracker(const Tracker&) = delete;
  Tracker& operator=(const Tracker&) = delete;

  /// The hands in the next frame, in the order of their ids. Throws an Error where the time is not finite, or
  /// another call has not ended.
  std::vector<TrackedHand> update(const Frame& frame);
  /// Begins anew, with id 1.
  void reset();

 private:
  void step_to(const Frame& frame);
  void follow(const Frame& frame);
  bool is_search_due() const;
  void look_for_more(const Frame& frame);
  void look_beside_hands(const Frame& frame);
  bool is_on_forearm(const Point3& place) const;
  std::vector<HandSkin> skins_near(const Point3& place, const HandTrack* own) const;
  void take_up(const Frame& frame, const HandEstimate& hand);
  bool take(const Frame& frame, const HandEstimate& estimate, HandTrack& track) const;
  HandTrack* least_trusted();
  HandTrack* lost_near(const Point3& middle);
  std::ptrdiff_t seen_count() const;
  void forget_and_part();
  std::vector<Point3> middles_seen() const;
  HandTrack* seen_near(const Point3& middle);
  std::vector<TrackedHand> hands_seen(const Frame& frame) const;

  const Pipeline& pipeline_;
  TrackerOptions options_;
  std::vector<HandTrack> tracks_;
  int next_id_ = 1;
  std::optional<double> now_s_;       // of the last frame
  std::optional<double> searched_s_;  // when all of a frame was searched last
  int sequence_ = 0;
  std::atomic<std::thread::id> user_{};  // none while nobody calls
};

}  // namespace knuckle
