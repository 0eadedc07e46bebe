// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace knuckle {

/// Items on their way from one thread to another, which never makes the first one wait: where it has no room,
/// an item is lost, and counted. Safe to use by many threads.
template <class Item>
class HandOver {
 public:
  /// What is lost where there is no room.
  enum class Lose {
    oldest,  ///< the newest wins: for what is shown
    newest,  ///< what was accepted stays: for what is recorded
  };

  /// `most`: items that may wait, at least 1.
  HandOver(std::size_t most, Lose lose) : most_(most), lose_(lose) {}

  /// Hands over an item; lost where the way is closed.
  void put(Item item) {
    {
      const std::lock_guard lock(mutex_);
      if (is_closed_) return;
      if (items_.size() == most_) {
        ++lost_;
        if (lose_ == Lose::newest) return;
        items_.pop_front();
      }
      items_.push_back(std::move(item));
    }
    has_changed_.notify_one();
  }

  /// The oldest item that waits; waits for one. Nothing once the way is closed and all is taken.
  std::optional<Item> take() {
    std::unique_lock lock(mutex_);
    has_changed_.wait(lock, [&] { return is_closed_ || !items_.empty(); });
    if (items_.empty()) return std::nullopt;
    Item item = std::move(items_.front());
    items_.pop_front();
    return item;
  }

  /// Nothing more comes.
  void close() {
    {
      const std::lock_guard lock(mutex_);
      is_closed_ = true;
    }
    has_changed_.notify_all();
  }

  std::int64_t lost() const {
    const std::lock_guard lock(mutex_);
    return lost_;
  }

 private:
  std::size_t most_;
  Lose lose_;
  mutable std::mutex mutex_;
  std::condition_variable has_changed_;
  std::deque<Item> items_;
  bool is_closed_ = false;
  std::int64_t lost_ = 0;
};

}  // namespace knuckle
