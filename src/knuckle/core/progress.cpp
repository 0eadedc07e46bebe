// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/progress.h"

#include <atomic>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace knuckle {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTerminalInterval{100};
constexpr std::chrono::seconds kLogInterval{30};

std::atomic<bool> is_progress_on = true;

}  // namespace

std::string readable_duration(double seconds) {
  const auto whole = std::llround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

Progress::Progress(std::string what, std::string unit, std::optional<std::int64_t> total, std::int64_t done)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      total_(total),
      done_before_(done),
      done_(done),
      is_terminal_(::isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      last_shown_(start_) {}

Progress::~Progress() {
  if (!is_shown_) return;
  show(Clock::now());
  if (is_terminal_) fmt::print(stderr, "\n");
}

void Progress::advance(std::int64_t steps) {
  const std::lock_guard lock(mutex_);
  done_ += steps;
  const auto now = Clock::now();
  const bool is_due =
      is_terminal_ ? now - last_shown_ >= kTerminalInterval : now - last_shown_ >= kLogInterval;
  if (!is_due || !is_progress_on) return;
  show(now);
  last_shown_ = now;
  is_shown_ = true;
}

/// "12 of 40 frames, 3.1/s, time left 9 s"; without a total "12 frames, 3.1/s".
std::string Progress::state_after(double seconds) const {
  const double rate = seconds > 0.0 ? static_cast<double>(done_ - done_before_) / seconds : 0.0;
  if (!total_) return fmt::format("{} {}, {:.1f}/s", done_, unit_, rate);
  const std::string left =
      rate > 0.0 ? readable_duration(static_cast<double>(*total_ - done_) / rate) : std::string("unknown");
  return fmt::format("{} of {} {}, {:.1f}/s, time left {}", done_, *total_, unit_, rate, left);
}

void Progress::show(Clock::time_point now) const {
  const double seconds = std::chrono::duration<double>(now - start_).count();
  fmt::print(stderr, "{}{}: {}{}", is_terminal_ ? "\r\x1b[K" : "", what_, state_after(seconds),
             is_terminal_ ? "" : "\n");
  std::fflush(stderr);
}

void show_progress(bool on) {
  is_progress_on = on;
}

}  // namespace knuckle
