// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/track_each.h"

#include <memory>

#include "knuckle/core/error.h"
#include "knuckle/core/ordered_work.h"
#include "knuckle/pipeline/run_warnings.h"
#include "knuckle/track/sequence_tracker.h"

namespace knuckle {
namespace {

/// The first frame of the sequence that a frame belongs to.
std::int64_t start_of_sequence(const FrameSource& source, std::int64_t frame) {
  if (frame == 0 || frame >= source.size()) return frame;
  const int sequence = source.read_label(frame).sequence;
  while (frame > 0 && source.read_label(frame - 1).sequence == sequence) --frame;
  return frame;
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
        FrameResult result = is_readable ? tracker.follow(number, reading->frame)
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
