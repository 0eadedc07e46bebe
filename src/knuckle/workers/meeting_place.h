// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <optional>
#include <string>

#include <torch/csrc/distributed/c10d/Store.hpp>

#include "knuckle/workers/worker_place.h"

namespace knuckle {

/// Where workers leave notes for each other, by name: a file of one machine, or a server in worker 0. Safe to
/// use from many threads.
class MeetingPlace {
 public:
  /// Throws an Error where worker 0 cannot listen, or cannot be reached within `wait_s`.
  MeetingPlace(const WorkerPlace& place, double wait_s);

  /// Leaves a note, also in place of one. Throws c10::Error or std::exception where worker 0 is gone.
  void say(const std::string& name, const std::string& note);
  /// The note of that name; nothing where there is none yet.
  std::optional<std::string> said(const std::string& name);

  const c10::intrusive_ptr<c10d::Store>& store() const { return store_; }

 private:
  c10::intrusive_ptr<c10d::Store> store_;
};

}  // namespace knuckle
