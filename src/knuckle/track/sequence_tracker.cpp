// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/sequence_tracker.h"

#include <algorithm>
#include <functional>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/pipeline/stopwatch.h"

namespace knuckle {
namespace {

const TrackerOptions& tracker_of(const Pipeline& pipeline) {
  if (!pipeline.tracker()) fail("the pipeline has no tracker: its file lacks the table [tracker]");
  return *pipeline.tracker();
}

HandEstimate estimate_of(const TrackedHand& hand, const Camera& camera) {
  HandEstimate estimate;
  estimate.region.centre = Projection(camera).to_camera(mean_joint(hand.pose));
  estimate.region.score = hand.score;
  estimate.pose = hand.pose;
  estimate.score = hand.score;
  estimate.side = hand.side;
  estimate.id = hand.id;
  estimate.angles = hand.angles;
  estimate.skeleton = hand.skeleton;
  return estimate;
}

}  // namespace

SequenceTracker::SequenceTracker(const Pipeline& pipeline) : tracker_(pipeline, tracker_of(pipeline)) {}

FrameResult SequenceTracker::follow(std::int64_t index, const Frame& frame) {
  if (frame.sequence != sequence_) tracker_.reset();
  sequence_ = frame.sequence;
  FrameResult result{index, frame.name, frame.time_s, frame.camera, {}, {}};
  const Stopwatch watch;
  for (const TrackedHand& hand : tracker_.update(frame))
    result.estimate.hands.push_back(estimate_of(hand, frame.camera));
  result.estimate.times.estimate_ms = watch.milliseconds();
  std::ranges::stable_sort(result.estimate.hands, std::greater{}, &HandEstimate::score);
  if (result.estimate.hands.empty()) result.estimate.status = "no hand is followed, and none is found";
  return result;
}

}  // namespace knuckle
