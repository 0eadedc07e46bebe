// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/estimate_each.h"

#include <memory>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/ordered_work.h"
#include "knuckle/core/parallel.h"
#include "knuckle/pipeline/run_warnings.h"

namespace knuckle {
namespace {

constexpr int kFramesPerThread = 4;
constexpr int kMostInFlight = 65536;

FrameResult result_of(std::int64_t index, const Frame& frame, const Pipeline& pipeline,
                      const RunOptions& options) {
  const Search search{.start = start_in(frame, options.start), .max_hands = pipeline.hand().max_hands};
  FrameResult result{index, frame.name, frame.time_s, frame.camera, pipeline.estimate(frame, search), {}};
  if (options.warnings != nullptr) options.warnings->add(frame, result.estimate);
  for (HandEstimate& hand : result.estimate.hands) hand.region.mask = {};
  return result;
}

FrameResult unreadable(std::int64_t index, std::string fault) {
  FrameResult result;
  result.index = index;
  result.estimate.status = fmt::format("the frame cannot be read: {}", fault);
  result.fault = std::move(fault);
  return result;
}

Delivery delivery_of(FrameResult result, const TakeResult& take) {
  return [&take, result = std::move(result)]() mutable { take(std::move(result)); };
}

/// What a stream had to give: a frame, or the reason why there is none.
struct Arrival {
  std::optional<Frame> frame;
  std::string fault;
};

Arrival next_of(FrameStream& stream) {
  try {
    return {stream.next(), {}};
  } catch (const Error& error) {
    return {std::nullopt, error.what()};
  }
}

/// Whoever reads frames in any order may tell a faulty image from faulty labels.
FrameResult result_of(const FrameSource& source, std::int64_t index, const Pipeline& pipeline,
                      const RunOptions& options) {
  Frame frame;
  try {
    frame = source.read(index);
  } catch (const Error& error) {
    return unreadable_frame(source, index, error.what());
  }
  return result_of(index, frame, pipeline, options);
}

}  // namespace

FrameResult unreadable_frame(const FrameSource& source, std::int64_t index, std::string fault) {
  const FrameLabel label = source.read_label(index);
  FrameResult result = unreadable(index, std::move(fault));
  result.name = label.name;
  result.time_s = label.time_s;
  result.camera = label.camera;
  return result;
}

int RunOptions::most_in_flight() const {
  return frames_in_flight > 0 ? frames_in_flight : kFramesPerThread * thread_count();
}

void RunOptions::check() const {
  if (first < 0) fail("first is {}, expected at least 0", first);
  if (frames_in_flight < 0 || frames_in_flight > kMostInFlight) {
    fail("frames_in_flight is {}, expected 0 to {}", frames_in_flight, kMostInFlight);
  }
}

void estimate_each(FrameStream& stream, const Pipeline& pipeline, const RunOptions& options,
                   const TakeResult& take) {
  options.check();
  std::int64_t index = options.first;
  const auto next = [&]() -> Job {
    // Shared, since a job can be copied; the images lie in it once.
    const auto arrival = std::make_shared<Arrival>(next_of(stream));
    if (!arrival->frame && arrival->fault.empty()) return {};
    return [&, arrival, number = index++] {
      FrameResult result = arrival->frame ? result_of(number, *arrival->frame, pipeline, options)
                                          : unreadable(number, std::move(arrival->fault));
      arrival->frame.reset();
      return delivery_of(std::move(result), take);
    };
  };
  run_in_order(next, options.most_in_flight());
}

void estimate_each(const FrameSource& source, const Pipeline& pipeline, const RunOptions& options,
                   const TakeResult& take) {
  options.check();
  if (options.first > source.size())
    fail("first is {}, the source has {} frames", options.first, source.size());
  require_start(source, options.start, "the source");
  std::int64_t index = options.first;
  const auto next = [&]() -> Job {
    if (index == source.size()) return {};
    return [&, number = index++] { return delivery_of(result_of(source, number, pipeline, options), take); };
  };
  run_in_order(next, options.most_in_flight());
}

}  // namespace knuckle
