// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/played_stream.h"

#include <algorithm>
#include <exception>
#include <thread>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"

namespace knuckle {
namespace {

constexpr double kUsualStepSeconds = 1.0 / 30.0;

}  // namespace

void PlayOptions::visit(OptionVisitor& visitor) {
  visitor.real("rate", rate_hz, closed(0, 10000));
  visitor.integer("loop", loop, closed(0, 1));
}

double PlayClock::due_s(const FrameLabel& frame) {
  const bool is_first = count_++ == 0;
  if (rate_hz_ > 0.0) return static_cast<double>(count_ - 1) / rate_hz_;
  const bool goes_on = !is_first && frame.sequence == last_sequence_ && frame.time_s && last_time_s_;
  if (!is_first) due_s_ += goes_on ? std::max(0.0, *frame.time_s - *last_time_s_) : kUsualStepSeconds;
  last_time_s_ = frame.time_s;
  last_sequence_ = frame.sequence;
  return due_s_;
}

PlayedStream::PlayedStream(std::unique_ptr<const FrameSource> source, const PlayOptions& options)
    : source_(std::move(source)), options_(options), clock_(options.rate_hz) {
  check_options(options_, "stream");
}

std::optional<Frame> PlayedStream::next() {
  if (position_ == source_->size()) {
    if (options_.loop == 0 || !is_any_readable_) return std::nullopt;
    position_ = 0;
    first_sequence_ = last_sequence_ + 1;
    is_any_readable_ = false;
  }
  const std::int64_t index = position_++;
  FrameLabel of_round;
  std::optional<Frame> frame;
  std::exception_ptr fault;
  try {
    const FrameLabel label = source_->read_label(index);
    of_round.time_s = label.time_s;
    of_round.sequence = first_sequence_ + label.sequence;
    frame = source_->read(index);
  } catch (const Error&) {
    fault = std::current_exception();
  }
  const double due_s = clock_.due_s(of_round);
  if (!began_) began_ = Clock::now();
  wait_until_due(due_s);  // a faulty frame takes its time as well
  if (fault) std::rethrow_exception(fault);
  is_any_readable_ = true;
  last_sequence_ = std::max(last_sequence_, of_round.sequence);
  frame->time_s = due_s;
  frame->sequence = of_round.sequence;
  return frame;
}

void PlayedStream::wait_until_due(double due_s) {
  constexpr std::chrono::milliseconds kLongestSleep{50};
  const auto due =
      *began_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(due_s));
  for (auto now = Clock::now(); now < due; now = Clock::now()) {
    end_if_interrupted();
    std::this_thread::sleep_for(std::min<Clock::duration>(due - now, kLongestSleep));
  }
  end_if_interrupted();
}

}  // namespace knuckle
