// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/watch.h"

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/interruption.h"

namespace knuckle {
namespace {

constexpr auto kBeat = std::chrono::seconds(1);
constexpr auto kTimeToStop = std::chrono::seconds(2);

std::string alive(int rank) {
  return fmt::format("alive/{}", rank);
}

}  // namespace

Watch::Watch(std::shared_ptr<MeetingPlace> notes, int rank, int size, double wait_s)
    : shared_(std::make_shared<Shared>()) {
  const int first = rank == 0 ? 1 : 0;
  const int end = rank == 0 ? size : 1;
  for (int k = first; k < end; ++k) shared_->heard.push_back({k, {}, Clock::now()});
  // A meeting place that does not answer holds the thread up for good: nobody waits for it then.
  std::thread([notes = std::move(notes), rank, wait_s, shared = shared_] {
    work(*notes, rank, wait_s, *shared);
  }).detach();
}

Watch::~Watch() {
  std::unique_lock lock(shared_->mutex);
  shared_->stop = true;
  shared_->stopped.notify_all();
  shared_->stopped.wait_for(lock, kTimeToStop, [&] { return shared_->has_ended; });
}

void Watch::work(MeetingPlace& notes, int rank, double wait_s, Shared& shared) {
  std::unique_lock lock(shared.mutex);
  for (std::int64_t beat = 0; !shared.stop; ++beat) {
    lock.unlock();
    try {
      notes.say(alive(rank), fmt::format("{}", beat));
      look_around(notes, wait_s, shared);
    } catch (const std::exception& error) {  // worker 0 is gone, and the notes with it
      const std::string_view text = error.what();
      const std::lock_guard guard(shared.mutex);
      shared.fault = fmt::format("its notes cannot be read: {}", text.substr(0, text.find('\n')));
      shared.has_fault = true;
    }
    if (shared.has_fault) set_interrupted(true);
    lock.lock();
    shared.stopped.wait_for(lock, kBeat, [&] { return shared.stop; });
  }
  shared.has_ended = true;
  shared.stopped.notify_all();
}

void Watch::look_around(MeetingPlace& notes, double wait_s, Shared& shared) {
  if (notes.said("fault")) shared.has_fault = true;
  for (Heard& heard : shared.heard) {
    const std::optional<std::string> beat = notes.said(alive(heard.rank));
    const std::lock_guard lock(shared.mutex);
    if (beat && *beat != heard.beat) {
      heard.beat = *beat;
      heard.when = Clock::now();
    } else if (std::chrono::duration<double>(Clock::now() - heard.when).count() > wait_s) {
      shared.has_fault = true;
    }
  }
}

std::string Watch::fault() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->fault;
}

std::vector<int> Watch::silent_for(double seconds) const {
  const std::lock_guard lock(shared_->mutex);
  std::vector<int> silent;
  for (const Heard& heard : shared_->heard) {
    if (std::chrono::duration<double>(Clock::now() - heard.when).count() > seconds)
      silent.push_back(heard.rank);
  }
  return silent;
}

}  // namespace knuckle
