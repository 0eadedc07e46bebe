// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <chrono>
#include <cstdint>

#include <torch/csrc/distributed/c10d/Store.hpp>

#include "knuckle/workers/join_workers.h"

namespace knuckle {

/// Messages have no time limit of their own: who is alive may be long at work before it sends one.
inline constexpr auto kNoTimeLimit = std::chrono::hours(24 * 365);

/// Workers that talk by groups of c10d's: what one more group of them needs.
class C10dWorkers : public JoinedWorkers {
 public:
  /// Where groups leave what they tell each other as they begin.
  virtual const c10::intrusive_ptr<c10d::Store>& store() = 0;
  /// Throws as `exchange` does where a worker is lost: to be called again and again while one waits for
  /// others.
  virtual void end_if_over() = 0;
  /// What is to be thrown where an exchange has failed: all groups are broken from then on.
  virtual WorkersFault fault_of_exchange(const std::string& reason) = 0;
  /// Counts one exchange.
  virtual void add_exchange(double seconds, std::int64_t bytes) = 0;
};

}  // namespace knuckle
