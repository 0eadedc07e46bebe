// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "knuckle/core/worker_group.h"
#include "knuckle/workers/worker_place.h"

namespace knuckle {

/// Something that all workers must have alike.
struct WorkerTrait {
  std::string what;   ///< as in "worker 1 of 2 has another build"
  std::string value;  ///< compared with worker 0's
};

/// How a worker joins the others.
struct JoinOptions {
  WorkerPlace place;
  double wait_s = 300.0;  ///< How long a worker that does not come or answer is waited for [s]
  std::vector<WorkerTrait> traits;
  /// Says whether the process of a worker that this one has started, or that has started this one, has
  /// ended, and how; may be empty.
  std::function<std::optional<std::string>()> fault_of_process;
  /// Called once the place is found where workers meet; may be empty.
  std::function<void()> has_met;
};

/// Thrown by `exchange` where another worker is lost or has failed.
class WorkersFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A group whose members can tell each other how they ended.
class JoinedWorkers : public WorkerGroup {
 public:
  /// What became of all, where `exchange` has thrown WorkersFault or this worker has failed: one line that
  /// names the worker that was lost or failed first. `own` is this worker's own fault, or empty. Only worker
  /// 0 knows; for the others nothing, or that worker 0 is lost.
  virtual std::optional<std::string> ended_with(const std::string& own) = 0;
  /// Whether another worker's end was seen: then Interrupted is no wish of the user's.
  virtual bool has_seen_fault() const = 0;
  /// The end where all went well.
  virtual void ended_well() = 0;
};

/// Whether this build can join workers at all.
bool has_workers();

/// Waits for all workers and connects them, by c10d's Gloo. Messages are neither encrypted nor signed: all
/// that can reach the machines' ports are trusted. Throws an Error that names the worker that did not come in
/// time, or has another trait than worker 0, and where the port is in use.
std::unique_ptr<JoinedWorkers> join_workers(const JoinOptions& options);

}  // namespace knuckle
