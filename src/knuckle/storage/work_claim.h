// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>

namespace knuckle {

/// The right to work that several processes, also of several machines, may come to at the same time: one has
/// it, the others wait. It is the lock of a file, so it ends with its process, however that ends; the file
/// itself is removed with the claim, and one that a killed process left does no harm.
class WorkClaim {
 public:
  /// Waits until nobody else has the claim of `file`, whose folder must be there; `on_wait` is called once
  /// where that takes time. Throws Interrupted where the program is asked to end meanwhile, and an Error that
  /// names the file where it cannot be locked.
  explicit WorkClaim(
      std::filesystem::path file, const std::function<void()>& on_wait = [] {});
  ~WorkClaim();
  WorkClaim(const WorkClaim&) = delete;
  WorkClaim& operator=(const WorkClaim&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace knuckle
