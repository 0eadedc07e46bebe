// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

namespace knuckle {

/// While it lives, work of the thread that made it ends (`is_interrupted`) also where `is_ended` is set,
/// which must outlive it: for one piece of work that is no longer wanted, while all other goes on. A second
/// one within it takes its place until that is gone.
class InterruptedBy {
 public:
  explicit InterruptedBy(const std::atomic<bool>& is_ended);
  ~InterruptedBy();
  InterruptedBy(const InterruptedBy&) = delete;
  InterruptedBy& operator=(const InterruptedBy&) = delete;

 private:
  const std::atomic<bool>* before_;
};

}  // namespace knuckle
