// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/track_each.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/ordered_work.h"
#include "knuckle/pipeline/run_warnings.h"
#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/track/tracker.h"

namespace knuckle {
namespace {

/// The first frame of the sequence that a frame belongs to.
std::int64_t start_of_sequence(const FrameSource& source, std::int64_t frame) {
  if (frame == 0 || frame >= source.size()) return frame;
  const int sequence = source.read_label(frame).sequence;
  while (frame > 0 && source.read_label(frame - 1).sequence == sequence) --frame;
  return frame;
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

/// Follows hands through the frames of a source, which come in order. Each sequence stands for itself, ids
/// included, so that it does not matter which of them was seen before.
class SequenceTracker {
 public:
  explicit SequenceTracker(const Pipeline& pipeline) : tracker_(pipeline, *pipeline.tracker()) {}

  std::vector<TrackedHand> update(const Frame& frame) {
    if (frame.sequence != sequence_) tracker_.reset();
    sequence_ = frame.sequence;
    return tracker_.update(frame);
  }

 private:
  Tracker tracker_;
  std::optional<int> sequence_;
};

FrameResult tracked(std::int64_t index, const Frame& frame, SequenceTracker& tracker) {
  FrameResult result{index, frame.name, frame.time_s, frame.camera, {}, {}};
  const Stopwatch watch;
  for (const TrackedHand& hand : tracker.update(frame))
    result.estimate.hands.push_back(estimate_of(hand, frame.camera));
  result.estimate.times.estimate_ms = watch.milliseconds();
  std::ranges::stable_sort(result.estimate.hands, std::greater{}, &HandEstimate::score);
  if (result.estimate.hands.empty()) result.estimate.status = "no hand is followed, and none is found";
  return result;
}

/// What a thread read of a source.
struct Reading {
  Frame frame;
  std::string fault;
};

Reading reading_of(const FrameSource& source, std::int64_t index) {
  try {
    return {source.read(index), {}};
  } catch (const Error& error) {
    return {{}, error.what()};
  }
}

}  // namespace

void track_each(const FrameSource& source, const Pipeline& pipeline, const RunOptions& options,
                const TakeResult& take) {
  options.check();
  if (!pipeline.tracker()) fail("the pipeline has no tracker: its file lacks the table [tracker]");
  if (options.start != Start::nearest) fail("a tracker chooses itself where to look; leave out --init truth");
  if (options.first > source.size()) {
    fail("first is {}, the source has {} frames", options.first, source.size());
  }
  SequenceTracker tracker(pipeline);
  std::int64_t index = start_of_sequence(source, options.first);
  const auto next = [&]() -> Job {
    if (index == source.size()) return {};
    return [&, number = index++]() -> Delivery {
      const auto reading = std::make_shared<Reading>(reading_of(source, number));
      return [&, number, reading] {
        const bool is_readable = reading->fault.empty();
        FrameResult result = is_readable ? tracked(number, reading->frame, tracker)
                                         : unreadable_frame(source, number, reading->fault);
        if (number < options.first) return;
        if (is_readable && options.warnings != nullptr)
          options.warnings->add(reading->frame, result.estimate);
        take(std::move(result));
      };
    };
  };
  run_in_order(next, options.most_in_flight());
}

}  // namespace knuckle
