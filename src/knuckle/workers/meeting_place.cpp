// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/meeting_place.h"

#include <chrono>
#include <exception>
#include <vector>

#include <torch/csrc/distributed/c10d/FileStore.hpp>
#include <torch/csrc/distributed/c10d/TCPStore.hpp>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// How long LibTorch looks for a file of notes that is gone, and holds its caller up.
constexpr auto kTimeToOpen = std::chrono::seconds(2);

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(1000.0 * seconds));
}

[[noreturn]] void fail_to_meet(const WorkerPlace& place, double wait_s) {
  if (place.rank == 0) {
    fail(
        "--workers: worker 0 cannot listen at {}, port {}: the port is in use, or the address is not this "
        "machine's; name "
        "others by MASTER_ADDR and MASTER_PORT",
        place.address, place.port);
  }
  fail(
      "--workers: worker {} of {} found no worker 0 at {}, port {} within {:g} s; start it, or name its "
      "address by "
      "MASTER_ADDR and MASTER_PORT",
      place.rank, place.size, place.address, place.port, wait_s);
}

c10::intrusive_ptr<c10d::Store> open_store(const WorkerPlace& place, double wait_s) {
  if (place.is_on_one_machine()) {
    auto notes = c10::make_intrusive<c10d::FileStore>((place.folder / "notes").string(), place.size);
    notes->setTimeout(kTimeToOpen);
    return notes;
  }
  c10d::TCPStoreOptions options;
  options.port = place.port;
  options.isServer = place.rank == 0;
  options.numWorkers = static_cast<std::size_t>(place.size);
  options.waitWorkers = false;
  options.timeout = milliseconds(wait_s);
  try {
    return c10::make_intrusive<c10d::TCPStore>(place.address, options);
  } catch (const std::exception&) {
    fail_to_meet(place, wait_s);
  }
}

}  // namespace

MeetingPlace::MeetingPlace(const WorkerPlace& place, double wait_s) : store_(open_store(place, wait_s)) {}

void MeetingPlace::say(const std::string& name, const std::string& note) {
  store_->set(name, std::vector<std::uint8_t>(note.begin(), note.end()));
}

std::optional<std::string> MeetingPlace::said(const std::string& name) {
  if (!store_->check({name})) return std::nullopt;
  const std::vector<std::uint8_t> note = store_->get(name);
  return std::string(note.begin(), note.end());
}

}  // namespace knuckle
