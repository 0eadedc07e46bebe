// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/run_live.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <optional>
#include <thread>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/hand_over.h"
#include "knuckle/core/interruption.h"
#include "knuckle/track/sequence_tracker.h"

namespace knuckle {
namespace {

using Clock = std::chrono::steady_clock;

struct Arrival {
  std::int64_t index;
  std::shared_ptr<const Frame> frame;
  Clock::time_point when;
};

/// The thread that waits for frames. It ends with its owner.
class Arrivals {
 public:
  Arrivals(FrameStream& stream, const LiveOptions& options)
      : stream_(stream), options_(options), thread_([this] { run(); }) {}
  ~Arrivals() { stop(); }
  Arrivals(const Arrivals&) = delete;
  Arrivals& operator=(const Arrivals&) = delete;

  /// The newest frame; nothing once the stream has ended.
  std::optional<Arrival> next() { return way_.take(); }
  std::int64_t arrived() const { return arrived_; }
  std::int64_t passed_over() const { return way_.lost(); }

  /// Ends the thread. What it counted is known then.
  void stop() {
    is_stopped_ = true;
    way_.close();
    if (thread_.joinable()) thread_.join();
  }
  /// Throws what ended the thread; call it after `stop`.
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }
  void add_counts(LiveCounts& counts) const {
    counts.arrived = arrived_;
    counts.passed_over = way_.lost();
    counts.unreadable = unreadable_;
    counts.fault = fault_;
    counts.lost = stream_.lost_frames();
    counts.why_camera_is_lost = why_camera_is_lost_;
  }

 private:
  void run() {
    try {
      while (!is_stopped_ && receive()) end_if_interrupted();
    } catch (const Interrupted&) {  // asked to end, it has ended
    } catch (...) {
      failure_ = std::current_exception();
    }
    way_.close();
  }

  /// False at the stream's end.
  bool receive() {
    std::optional<Frame> frame;
    try {
      frame = stream_.next();
    } catch (const DeviceLost& error) {
      why_camera_is_lost_ = error.what();
      return false;
    } catch (const Error& error) {
      if (unreadable_++ == 0) fault_ = error.what();
      return true;
    }
    if (!frame) return false;
    const auto when = Clock::now();
    const auto shared = std::make_shared<const Frame>(*std::move(frame));
    const std::int64_t index = arrived_++;
    if (options_.at_arrival) options_.at_arrival(index, shared);
    way_.put({index, shared, when});
    return true;
  }

  FrameStream& stream_;
  const LiveOptions& options_;
  HandOver<Arrival> way_{1, HandOver<Arrival>::Lose::oldest};
  std::atomic<bool> is_stopped_ = false;
  std::atomic<std::int64_t> arrived_ = 0;
  std::int64_t unreadable_ = 0;
  std::string fault_;
  std::string why_camera_is_lost_;
  std::exception_ptr failure_;
  std::thread thread_;  // the last: it uses the others
};

FrameResult single(std::int64_t index, const Frame& frame, const Pipeline& pipeline) {
  return {index,
          frame.name,
          frame.time_s,
          frame.camera,
          pipeline.estimate(frame, {.max_hands = pipeline.hand().max_hands}),
          {}};
}

double seconds_from(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

void check(const LiveOptions& options) {
  if (options.most_frames < 0) fail("live: frames is {}, expected 0 or more", options.most_frames);
  if (!(options.most_seconds >= 0.0) || !std::isfinite(options.most_seconds))
    fail("live: seconds is {}, expected 0 or more", options.most_seconds);
}

}  // namespace

LiveCounts run_live(FrameStream& stream, const Pipeline& pipeline, const LiveOptions& options,
                    const std::function<void(const LiveFrame&)>& take) {
  check(options);
  std::optional<SequenceTracker> tracker;
  if (pipeline.tracker()) tracker.emplace(pipeline);
  LiveCounts counts;
  Arrivals arrivals(stream, options);
  std::optional<Clock::time_point> began;
  while (std::optional<Arrival> arrival = arrivals.next()) {
    if (!began) began = arrival->when;
    FrameResult result = tracker ? tracker->follow(arrival->index, *arrival->frame)
                                 : single(arrival->index, *arrival->frame, pipeline);
    ++counts.results;
    counts.found += result.estimate.hands.empty() ? 0 : 1;
    take({arrival->frame, std::move(result), 1000.0 * seconds_from(arrival->when), arrivals.arrived(),
          arrivals.passed_over()});
    if (is_interrupted() || counts.results == options.most_frames) break;
    if (options.most_seconds > 0.0 && seconds_from(*began) >= options.most_seconds) break;
  }
  arrivals.stop();
  arrivals.rethrow();
  arrivals.add_counts(counts);
  return counts;
}

}  // namespace knuckle
