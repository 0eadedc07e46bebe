// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <unordered_set>

namespace knuckle {

/// A set of whole numbers from `first` on, most of which come in order: only those that came before their
/// turn take room.
class IndexSet {
 public:
  explicit IndexSet(std::int64_t first) : first_(first), end_(first) {}

  /// False where it is there already. `index` is at least `first`.
  bool insert(std::int64_t index) {
    if (contains(index)) return false;
    early_.insert(index);
    while (early_.erase(end_) > 0) ++end_;
    return true;
  }
  bool contains(std::int64_t index) const {
    return (index >= first_ && index < end_) || early_.contains(index);
  }
  std::int64_t size() const { return end_ - first_ + static_cast<std::int64_t>(early_.size()); }
  bool empty() const { return size() == 0; }

 private:
  std::int64_t first_;
  std::int64_t end_;  ///< all from `first` to before it are there
  std::unordered_set<std::int64_t> early_;
};

}  // namespace knuckle
