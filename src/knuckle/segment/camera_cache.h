// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "knuckle/core/camera.h"

namespace knuckle {

/// Keeps what was computed for the last cameras asked for: the frames of a recording share one. `Table` has a
/// `camera()`. Safe to call from many threads; a table lives as long as its users.
template <class Table>
class CameraCache {
 public:
  using Make = std::function<std::shared_ptr<const Table>(const Camera&)>;
  explicit CameraCache(Make make) : make_(std::move(make)) {}

  /// Throws an Error where the camera's values are impossible.
  std::shared_ptr<const Table> of(const Camera& camera) {
    if (auto known = known_of(camera)) return known;
    check(camera);
    // Outside of the lock: where every frame has a camera of its own, threads would wait for one another.
    std::shared_ptr<const Table> made = make_(camera);
    const std::lock_guard lock(mutex_);
    last_.insert(last_.begin(), made);
    if (last_.size() > kKept) last_.pop_back();
    return made;
  }

 private:
  static constexpr std::size_t kKept = 4;

  /// Empty where it is not kept.
  std::shared_ptr<const Table> known_of(const Camera& camera) {
    const std::lock_guard lock(mutex_);
    const auto known = std::ranges::find(last_, camera, [](const auto& table) { return table->camera(); });
    if (known == last_.end()) return nullptr;
    std::rotate(last_.begin(), known, known + 1);
    return last_.front();
  }

  Make make_;
  std::mutex mutex_;
  std::vector<std::shared_ptr<const Table>> last_;  // the latest first
};

}  // namespace knuckle
