// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "knuckle/workers/meeting_place.h"

namespace knuckle {

/// A thread that says that this worker is alive, and looks whether the others are: worker 0 at all of them,
/// the others at worker 0. Where one fails or does not answer, work that `parallel_for` does here is ended.
class Watch {
 public:
  Watch(std::shared_ptr<MeetingPlace> notes, int rank, int size, double wait_s);
  /// Does not wait where the meeting place does not answer.
  ~Watch();
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  /// Whether a worker has failed, or has not answered for the time to wait.
  bool has_seen_fault() const { return shared_->has_fault; }
  /// What it saw; empty where that is another worker's report, or nothing.
  std::string fault() const;
  /// Workers that have not been heard of for longer than `seconds`.
  std::vector<int> silent_for(double seconds) const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Heard {
    int rank = 0;
    std::string beat;
    Clock::time_point when;
  };
  /// What the thread uses: it may outlive this object.
  struct Shared {
    std::mutex mutex;
    std::condition_variable stopped;
    bool stop = false;
    bool has_ended = false;
    std::atomic<bool> has_fault = false;
    std::string fault;
    std::vector<Heard> heard;
  };
  static void work(MeetingPlace& notes, int rank, double wait_s, Shared& shared);
  static void look_around(MeetingPlace& notes, double wait_s, Shared& shared);

  std::shared_ptr<Shared> shared_;
};

}  // namespace knuckle
