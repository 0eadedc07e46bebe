// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

namespace knuckle {

/// Shows how far long work has come, with rate and (where its end is known) time left, on standard error: one
/// line that is rewritten on a terminal, a line now and then elsewhere. Safe to call from many threads.
class Progress {
 public:
  /// `what` names the work, `unit` what is counted, as in Progress("render", "frames", 4000). Without a total
  /// (a stream) nobody knows when it ends. `done` steps were done by an earlier run: they count, but not in
  /// the rate.
  Progress(std::string what, std::string unit, std::optional<std::int64_t> total, std::int64_t done = 0);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::int64_t steps = 1);

 private:
  std::string state_after(double seconds) const;
  void show(std::chrono::steady_clock::time_point now) const;

  std::string what_;
  std::string unit_;
  std::optional<std::int64_t> total_;
  std::int64_t done_before_;
  std::int64_t done_;
  bool is_terminal_;
  bool is_shown_ = false;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_shown_;
  std::mutex mutex_;
};

/// A duration for a person, as "40 s", "3 min 05 s" or "2 h 10 min".
std::string readable_duration(double seconds);

/// Switches all progress output on or off (on at the start).
void show_progress(bool on);

}  // namespace knuckle
