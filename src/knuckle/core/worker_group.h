// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// One message per worker, in the order of the workers, one after another.
struct Messages {
  std::vector<std::byte> bytes;
  std::vector<std::int64_t> sizes;  ///< of each message [bytes]; their sum is the size of `bytes`
};

/// Processes that work on one thing together, on one machine or several. All make the same calls in the same
/// order. Not safe to call from several threads at a time.
class WorkerGroup {
 public:
  virtual ~WorkerGroup() = default;

  /// This process's number, in [0, size). Worker 0 writes what comes out.
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// This process's number among those of its machine, as far as it is known; each may have a GPU of its own.
  virtual int number_on_machine() const { return rank(); }
  /// Sends message k of `sent` to worker k, for all k, this one included. Returns what all have sent to this
  /// one, in the order of the workers; `sizes` says how many bytes that is of each. Throws where a worker is
  /// lost or has failed (no Error: nobody may work around it), and Interrupted.
  virtual std::vector<std::byte> exchange(Messages sent, const std::vector<std::int64_t>& sizes) = 0;
  /// How long `exchange` has taken in all, waiting for slower workers included [s].
  virtual double seconds_in_exchange() const = 0;
  /// What this worker has sent to the others in all.
  virtual std::int64_t bytes_sent() const = 0;
};

/// What each worker says, in the order of the workers; at most 1 GiB each.
std::vector<std::string> gathered(WorkerGroup& workers, std::string_view own);

/// What worker 0 says; the others' `own` does not count.
std::string from_first(WorkerGroup& workers, std::string_view own);

/// Throws an Error with all workers where one says something else than worker 0: "worker 2 of 4 has `what`
/// than worker 0", as in what = "other weights".
void require_same(WorkerGroup& workers, std::string_view what, std::string_view own);

/// A worker's part [begin, end) of some things.
struct PartOfWork {
  std::int64_t begin = 0;
  std::int64_t end = 0;
  std::int64_t size() const { return end - begin; }
};
/// The part of `count` things that worker `rank` of `size` takes: parts are contiguous, in the order of the
/// workers, and differ by one thing at most.
PartOfWork part_of_worker(std::int64_t count, int rank, int size);

}  // namespace knuckle
